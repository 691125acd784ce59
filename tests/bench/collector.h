// Shared by the benchmarks: a reporter that keeps the rates, so that ratios can be printed at the end and written as
// results (host/files/results_file.h).
#ifndef SELFPROJ_TESTS_BENCH_COLLECTOR_H
#define SELFPROJ_TESTS_BENCH_COLLECTOR_H

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/files/results_file.h"

namespace selfproj::bench {

// Passes the defaults of our benchmarks (seven repetitions, interleaved) to Google Benchmark, and then the options of
// the command line, which override them. Prints a message and returns false if an option is unknown.
inline bool initialize(const char* program, const std::vector<std::string>& options) {
  static std::vector<std::string> words;  // Google Benchmark keeps the pointer to the program's name
  words = {program, "--benchmark_repetitions=7", "--benchmark_enable_random_interleaving=true",
           "--benchmark_min_time=0.2"};
  words.insert(words.end(), options.begin(), options.end());
  std::vector<char*> arguments;
  for (std::string& word : words) {
    arguments.push_back(word.data());
  }
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  return !benchmark::ReportUnrecognizedArguments(count, arguments.data());
}

// Prints the medians as a table and keeps one rate of every repetition: "bytes_per_second" or "items_per_second".
class Collector : public benchmark::ConsoleReporter {
 public:
  explicit Collector(std::string rate) : ConsoleReporter(OO_Tabular), rate_(std::move(rate)) {}

  void ReportRuns(const std::vector<Run>& runs) override {
    std::vector<Run> shown;
    for (const Run& run : runs) {
      failed_ = failed_ || went_wrong(run);
      const auto rate = run.counters.find(rate_);
      if (run.run_type == Run::RT_Iteration && rate != run.counters.end()) {
        rates_[run.run_name.function_name].push_back(rate->second.value);
      }
      if (went_wrong(run) || run.aggregate_name == "median") {
        shown.push_back(run);
      }
    }
    ConsoleReporter::ReportRuns(shown);
  }

  [[nodiscard]] bool failed() const { return failed_; }

  // The median of the repetitions; 0 if the benchmark did not run (--benchmark_filter).
  [[nodiscard]] double median(const std::string& name) const {
    const auto found = rates_.find(name);
    if (found == rates_.end()) {
      return 0;
    }
    std::vector<double> rates = found->second;
    std::sort(rates.begin(), rates.end());
    return (rates[(rates.size() - 1) / 2] + rates[rates.size() / 2]) / 2;
  }

 private:
  // Newer versions of Google Benchmark have another member for it.
  template <class Run>
  static bool went_wrong(const Run& run) {
    if constexpr (requires { run.error_occurred; }) {
      return run.error_occurred;
    } else {
      return run.skipped != 0;
    }
  }

  std::string rate_;
  std::map<std::string, std::vector<double>> rates_;
  bool failed_ = false;
};

// Describes the measurement of a benchmark.
struct About {
  const char* name;  // name of its file in results/
  const char* text;
  const char* rate;  // the rate that counts: "bytes_per_second" or "items_per_second"
};

// Runs the registered benchmarks. Unless one fails, `print` then gets the collector, prints ratios and returns the
// results as JSON. Returns the exit status of the program.
template <typename Print>
int run_registered(const About& about, const Print& print) {
  Collector collector(about.rate);
  benchmark::RunSpecifiedBenchmarks(&collector);
  if (!collector.failed()) {
    const nlohmann::ordered_json results = print(collector);
    if (!results.empty()) {  // left out by --benchmark_filter
      files::write_results(about.name, about.text, results);
    }
  }
  benchmark::Shutdown();
  return collector.failed() ? 1 : 0;
}

// Ends the program with exit status 1 and this message unless results are right.
inline void require(bool right, const std::string& otherwise) {
  if (!right) {
    throw std::runtime_error(otherwise);
  }
}

// Registers a benchmark.
template <typename Function>
void add(const std::string& name, Function function) {
  benchmark::RegisterBenchmark(name.c_str(), std::move(function));
}

// How many items an iteration has, and how many bytes an item.
inline void set_counters(benchmark::State& state, std::int64_t items, std::size_t bytes_of_one) {
  state.SetItemsProcessed(state.iterations() * items);
  state.SetBytesProcessed(state.iterations() * items * static_cast<std::int64_t>(bytes_of_one));
}

// The main function of a benchmark with options of Google Benchmark. `run` compares results, registers benchmarks and
// returns run_registered(). The exit status is 2 for an unknown option, and 1, with the reason in one line, if `run`
// throws.
template <typename Run>
int main_of(const char* name, const std::vector<std::string>& options, const Run& run) {
  try {
    return initialize(name, options) ? run() : 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", name, error.what());
    return 1;
  }
}

}  // namespace selfproj::bench

#endif  // SELFPROJ_TESTS_BENCH_COLLECTOR_H
