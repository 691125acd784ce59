// What a Verilated model begins with, and builds that count coverage or have mutations.
#ifndef SELFPROJ_SIM_BOARD_VERILATED_MODEL_H
#define SELFPROJ_SIM_BOARD_VERILATED_MODEL_H

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#ifdef SELFPROJ_COVERAGE
#include <unistd.h>
#include <verilated.h>
#include <verilated_cov.h>
#endif

namespace selfproj::sim {

// Coverage of the RTL by a program, in builds with SELFPROJ_COVERAGE (scripts/coverage.py).
//
// Verilated models count in their own memory, which must still exist when the counts are written. In such a build a
// model is therefore never destroyed but reused for the next test case. The counts are written when the program ends,
// to the file that SELFPROJ_COVERAGE_FILE names with the process number appended. In other builds every test case has a
// new model.

#ifdef SELFPROJ_COVERAGE

// Writes the counts of a context when the program ends.
class CoverageFile {
 public:
  explicit CoverageFile(VerilatedContext& context) : context_(context), number_(count_++) {}
  CoverageFile(const CoverageFile&) = delete;
  CoverageFile& operator=(const CoverageFile&) = delete;
  ~CoverageFile() {
    if (const char* path = std::getenv("SELFPROJ_COVERAGE_FILE"); path != nullptr) {
      const std::string name = std::string(path) + '.' + std::to_string(getpid()) + '.' + std::to_string(number_);
      context_.coveragep()->write(name.c_str());
    }
  }

 private:
  inline static int count_ = 0;
  VerilatedContext& context_;
  int number_;
};

#endif

// A T from make() that is returned to the pool at the end of its use.
template <typename T>
class Reusable {
 public:
#ifdef SELFPROJ_COVERAGE
  template <typename Make>
  explicit Reusable(Make make) {
    if (free_.empty()) {
      all_.push_back(make());
      free_.push_back(all_.back().get());
    }
    object_ = free_.back();
    free_.pop_back();
  }
  ~Reusable() { free_.push_back(object_); }
#else
  template <typename Make>
  explicit Reusable(Make make) : owner_(make()), object_(owner_.get()) {}
#endif
  Reusable(const Reusable&) = delete;
  Reusable& operator=(const Reusable&) = delete;

  T& operator*() const { return *object_; }
  T* operator->() const { return object_; }

 private:
#ifdef SELFPROJ_COVERAGE
  inline static std::vector<std::unique_ptr<T>> all_;
  inline static std::vector<T*> free_;
#else
  std::unique_ptr<T> owner_;
#endif
  T* object_;
};

// Returns the context for the model that it is to hold. Registers begin with zeros, or, where the environment variable
// SELFPROJ_INITIAL_SEED is a number, with the random values of that seed.
template <class Context>
Context* with_initial_values(Context& context) {
  if (const char* seed = std::getenv("SELFPROJ_INITIAL_SEED"); seed != nullptr) {
    context.randReset(2);
    context.randSeed(static_cast<int>(std::strtol(seed, nullptr, 10)));
  }
  return &context;
}

// Selects the mutation of a model that was built with mutations: such a model has an input `mutant`.
//
// The environment variable SELFPROJ_MUTANT names model and number ("Vsp_fifo 17"). Without it, and for every other
// model, the number is 0, which means none. With SELFPROJ_MUTANT_USES the program writes a line "uses: MODEL" for every
// such model that it makes.

template <class Model>
void choose_mutant(Model& model) {
  if constexpr (requires { model.mutant; }) {
    model.mutant = 0;
    const char* name = model.modelName();
    if (std::getenv("SELFPROJ_MUTANT_USES") != nullptr) {
      std::printf("uses: %s\n", name);
    }
    const char* chosen = std::getenv("SELFPROJ_MUTANT");
    const std::size_t length = std::strlen(name);
    if (chosen != nullptr && std::strncmp(chosen, name, length) == 0 && chosen[length] == ' ') {
      model.mutant = static_cast<std::uint16_t>(std::strtoul(chosen + length, nullptr, 10));
    }
  }
}

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_BOARD_VERILATED_MODEL_H
