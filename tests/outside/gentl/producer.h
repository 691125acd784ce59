// Loads a GenTL producer as a consumer of GenTL does, and calls its functions.
#ifndef SELFPROJ_TESTS_OUTSIDE_GENTL_PRODUCER_H
#define SELFPROJ_TESTS_OUTSIDE_GENTL_PRODUCER_H

#include <dlfcn.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/gentl/gentl_types.h"

namespace selfproj::test {

// A loaded producer. It finds the functions of the standard by their names. If the file or a function is missing, it
// prints the reason and ends the program.
struct Producer {
  explicit Producer(const std::string& path) : library(dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL)) {
    if (library == nullptr) {
      std::fprintf(stderr, "%s\n", dlerror());
      std::exit(1);
    }
  }

  template <typename Function>
  Function* function(const char* name) const {
    void* const found = dlsym(library, name);
    if (found == nullptr) {
      std::fprintf(stderr, "%s\n", dlerror());
      std::exit(1);
    }
    return reinterpret_cast<Function*>(found);
  }

  void* library;  // never unloaded, so that the sanitizers can name the functions that leak
};

// The producer of this build.
inline const Producer& producer() {
  static const Producer one(SELFPROJ_GENTL_PRODUCER);
  return one;
}

// Calls a function of the producer: call(GC(TLOpen), &handle).
#define GC(name) ::selfproj::test::producer().function<decltype(::name)>(#name)

// The code and the text of the last error of this thread.
struct GenTLFailure {
  GC_ERROR code = GC_ERR_SUCCESS;
  std::string text;
};

inline GenTLFailure last_failure() {
  GenTLFailure found;
  std::size_t size = 0;
  if (GC(GCGetLastError)(&found.code, nullptr, &size) != GC_ERR_SUCCESS || size == 0) {
    return {GC_ERR_ERROR, "GCGetLastError failed"};
  }
  std::vector<char> text(size);
  if (GC(GCGetLastError)(&found.code, text.data(), &size) != GC_ERR_SUCCESS) {
    return {GC_ERR_ERROR, "GCGetLastError failed"};
  }
  found.text = text.data();
  return found;
}

// Calls a function that fills (type, buffer, size), such as DSGetInfo, and returns its answer as a value of this type.
// Throws std::runtime_error if the call fails or the answer has another size.
template <typename Value, typename Ask>
Value answer_of(const Ask& ask) {
  INFO_DATATYPE type = INFO_DATATYPE_UNKNOWN;
  Value value{};
  std::size_t size = sizeof value;
  if (ask(&type, &value, &size) != GC_ERR_SUCCESS) {
    throw std::runtime_error(last_failure().text);
  }
  if (size != sizeof value) {
    throw std::runtime_error("an answer of another size");
  }
  return value;
}

// The same for an answer that is a text of any length.
template <typename Ask>
std::string text_of(const Ask& ask) {
  INFO_DATATYPE type = INFO_DATATYPE_UNKNOWN;
  std::size_t size = 0;
  if (ask(&type, nullptr, &size) != GC_ERR_SUCCESS) {
    throw std::runtime_error(last_failure().text);
  }
  std::vector<char> text(size);
  if (ask(&type, text.data(), &size) != GC_ERR_SUCCESS) {
    throw std::runtime_error(last_failure().text);
  }
  return text.data();
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_OUTSIDE_GENTL_PRODUCER_H
