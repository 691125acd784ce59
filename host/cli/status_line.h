#ifndef SELFPROJ_HOST_CLI_STATUS_LINE_H
#define SELFPROJ_HOST_CLI_STATUS_LINE_H

#include <string>

namespace selfproj {

// One line on standard error that is rewritten again and again, and disappears at the end. Only on a terminal.
class StatusLine {
 public:
  StatusLine();
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;
  ~StatusLine();

  // Whether the line is shown.
  [[nodiscard]] bool visible() const { return terminal_; }

  void show(const std::string& text);

 private:
  bool terminal_;
  bool shown_ = false;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CLI_STATUS_LINE_H
