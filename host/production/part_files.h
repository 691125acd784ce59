// The files of a run with parts: a line for each part, and a folder for each that is not good.
#ifndef SELFPROJ_HOST_PRODUCTION_PART_FILES_H
#define SELFPROJ_HOST_PRODUCTION_PART_FILES_H

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "host/files/file_descriptor.h"
#include "host/files/temporary.h"
#include "host/production/part_result.h"

namespace selfproj::production {

// Writes into a new or empty folder
//   parts.jsonl, parts.csv   a line for each part, whole, as soon as it is classified
//   part_NNNNNN/             for each part that is bad or inconclusive, up to a number of folders:
//                            result.json, height.tiff, difference.tiff, difference.png with the defects marked; it
//                            appears whole
//   statistics.json          at the end, for which room is kept from the beginning
// Where the disk is full, lines, folders and rows are left out whole until there is room again; the parts' numbers show
// it, and check() says it at the end.
// The folders are written by a thread of their own. If it falls behind by more than kMaxWaiting parts, folders are
// left out and counted; the lines never are.
class PartFiles {
 public:
  static constexpr std::size_t kMaxWaiting = 8;

  // Makes the folder. Throws UserError if it cannot be made, or holds a file already.
  PartFiles(const std::string& folder, std::uint64_t max_folders);
  PartFiles(const PartFiles&) = delete;
  PartFiles& operator=(const PartFiles&) = delete;
  // If nothing was added and the production was not finished, nothing stays: the next run needs a new folder.
  ~PartFiles();

  // A file that cannot be written is noted on standard error, the first time, and the production goes on.
  void add(const PartResult& result, const PlacedMaps& maps);
  void finish(const PartStatistics& statistics);

  // Throws what was the first to fail, if anything did.
  void check() const;

  [[nodiscard]] std::uint64_t folders() const { return folders_; }
  [[nodiscard]] std::uint64_t folders_left_out() const { return left_out_; }

 private:
  struct Waiting {
    PartResult result;
    PlacedMaps maps;
  };

  void run(const std::stop_token& stop);
  void write_folder(const Waiting& part) const;
  void attempt(const std::function<void()>& write);

  bool existed_;  // the folder did, and is empty otherwise
  bool used_ = false;
  std::filesystem::path folder_;
  std::uint64_t max_folders_;
  files::FileDescriptor lines_;
  files::FileDescriptor table_;
  std::optional<files::Temporary> room_;  // for the statistics
  std::atomic<std::uint64_t> folders_{0};
  std::atomic<std::uint64_t> left_out_{0};
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<Waiting> waiting_;
  std::exception_ptr fault_;
  std::jthread thread_;  // at its end it writes what is waiting
};

// The picture of a part's difference, with its defects marked, as PNG.
std::string part_picture(const PartResult& result, const PlacedMaps& maps);

}  // namespace selfproj::production

#endif  // SELFPROJ_HOST_PRODUCTION_PART_FILES_H
