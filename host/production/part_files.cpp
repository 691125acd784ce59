#include "host/production/part_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/types.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <mutex>
#include <nlohmann/json.hpp>
#include <stop_token>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "host/files/file_descriptor.h"
#include "host/files/give_way.h"
#include "host/files/json_text.h"
#include "host/files/notes.h"
#include "host/files/output_file.h"
#include "host/files/output_folder.h"
#include "host/files/run_files.h"
#include "host/files/signals_held.h"
#include "host/report/map_picture.h"
#include "selfproj/files/user_error.h"
#include "selfproj/images/float_image.h"

namespace selfproj::production {
namespace fs = std::filesystem;
namespace {

constexpr const char* kLines = "parts.jsonl";
constexpr const char* kTable = "parts.csv";
constexpr const char* kStatistics = "statistics.json";

int open_new(const fs::path& file) {
  const int descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0666);
  if (descriptor < 0) {
    throw UserError(file, files::error_text(errno));
  }
  return descriptor;
}

fs::path made_folder(const std::string& name) {
  if (name.empty()) {
    throw UserError("--parts", "the name is empty");
  }
  std::error_code error;
  if (fs::exists(name, error) && !fs::is_directory(name, error)) {
    throw UserError(name, "exists and is not a folder");
  }
  if (fs::is_directory(name, error) && !fs::is_empty(name, error)) {
    throw UserError(name, "is not empty; the results of a run need a new folder");
  }
  for (const char* const file : {kLines, kTable, kStatistics}) {
    files::note_output(fs::path(name) / file, fs::path(name) / file);
  }
  fs::create_directories(name, error);
  if (error) {
    throw UserError(name, error.message());
  }
  return name;
}

// Appends the whole line, or nothing.
void append_line(const files::FileDescriptor& file, const fs::path& name, const std::string& line) {
  const off_t before = lseek(file.number(), 0, SEEK_END);
  if (!files::write_all(file.number(), line)) {
    const int error = errno;
    static_cast<void>(ftruncate(file.number(), before) == 0);
    throw UserError(name, files::error_text(error));
  }
}

}  // namespace

std::string part_picture(const PartResult& result, const PlacedMaps& maps) {
  std::vector<report::MapMark> marks;
  for (const Defect& defect : result.defects) {
    marks.push_back({maps.grid.row_of(defect.along_mm), maps.grid.column_of(defect.across_mm),
                     defect.size_along_mm / maps.grid.pitch_mm, defect.size_across_mm / maps.grid.pitch_mm});
  }
  // Belt and walls may differ by much more than a defect, whose colour would be pale.
  const report::MapScale scale = report::difference_scale(maps.difference, deepest_mm(result.defects));
  const report::MapPitch pitch{maps.grid.pitch_mm, maps.grid.pitch_mm, "along", "across"};
  return report::labelled_map_png(maps.difference, scale, pitch,
                                  fmt::format("part {}: {}", result.number, verdict_name(result.verdict)), marks);
}

PartFiles::PartFiles(const std::string& folder, std::uint64_t max_folders)
    : existed_(fs::exists(folder)),
      folder_(made_folder(folder)),
      max_folders_(max_folders),
      lines_(open_new(folder_ / kLines)),
      table_(open_new(folder_ / kTable)) {
  append_line(table_, folder_ / kTable, part_csv_head());
  constexpr off_t kRoom = 1 << 16;
  room_.emplace(folder, folder_, files::Temporary::Kind::file);
  const int error = posix_fallocate(room_->descriptor().number(), 0, kRoom);
  if (error == ENOSPC || error == EDQUOT) {  // otherwise the file system cannot tell
    throw UserError(folder, files::error_text(error));
  }
  const files::SignalsHeld held;  // signals are for the main thread
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

PartFiles::~PartFiles() {
  thread_.request_stop();
  if (thread_.joinable()) {
    thread_.join();
  }
  if (used_) {
    return;
  }
  std::error_code error;  // whatever cannot be removed stays
  room_.reset();
  fs::remove(folder_ / kLines, error);
  fs::remove(folder_ / kTable, error);
  if (!existed_) {
    fs::remove(folder_, error);
  }
}

void PartFiles::check() const {
  const std::lock_guard lock(mutex_);
  if (fault_) {
    std::rethrow_exception(fault_);
  }
}

void PartFiles::attempt(const std::function<void()>& write) {
  try {
    write();
  } catch (const UserError& error) {
    const std::lock_guard lock(mutex_);
    if (!fault_) {
      fault_ = std::current_exception();
      files::note(fmt::format("{}; the line goes on without", error.what()));
    }
  }
}

void PartFiles::add(const PartResult& result, const PlacedMaps& maps) {
  used_ = true;
  attempt([&] { append_line(lines_, folder_ / kLines, files::json_text(part_json(result)) + "\n"); });
  attempt([&] { append_line(table_, folder_ / kTable, part_csv(result)); });
  if (result.verdict == Verdict::good) {
    return;
  }
  {
    const std::lock_guard lock(mutex_);
    if (folders_ >= max_folders_ || waiting_.size() >= kMaxWaiting) {
      ++left_out_;
      return;
    }
    ++folders_;
    waiting_.push_back({result, maps});
  }
  changed_.notify_all();
}

void PartFiles::write_folder(const Waiting& part) const {
  files::OutputFolder folder(folder_ / fmt::format("part_{:06}", part.result.number));
  folder.append("result.json", files::json_text(part_json(part.result), 2) + "\n");
  folder.append("height.tiff", images::encode_float_tiff("height.tiff", part.maps.height));
  folder.append("difference.tiff", images::encode_float_tiff("difference.tiff", part.maps.difference));
  folder.append("difference.png", part_picture(part.result, part.maps));
  folder.commit();
}

void PartFiles::run(const std::stop_token& stop) {
  files::give_way();
  std::unique_lock lock(mutex_);
  for (;;) {
    if (!changed_.wait(lock, stop, [this] { return !waiting_.empty(); })) {
      return;
    }
    const Waiting part = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    attempt([&] { write_folder(part); });
    lock.lock();
  }
}

void PartFiles::finish(const PartStatistics& statistics) {
  used_ = true;
  thread_.request_stop();
  thread_.join();
  room_.reset();
  const std::string name = folder_ / kStatistics;
  attempt([&] {
    files::Temporary file(name, folder_, files::Temporary::Kind::file);
    const int number = file.descriptor().number();
    if (!files::write_all(number, files::json_text(statistics_json(statistics), 2) + "\n") || fsync(number) != 0 ||
        rename(file.path().c_str(), name.c_str()) != 0) {
      throw UserError(name, files::error_text(errno));
    }
    file.keep();
  });
}

}  // namespace selfproj::production
