// Control of a board: its registers by name, its settings, its counters.
//
//     const std::unique_ptr<Control> control = open_control("udp:192.168.1.50");
//     control->set({.run = true, .columns = 512, .rows = 96, .mode = Mode::grey_over, .threshold = 60});
//     control->write("trigger_period.clocks", 15120);
#ifndef SELFPROJ_HOST_DRIVER_CONTROL_H
#define SELFPROJ_HOST_DRIVER_CONTROL_H

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/driver/register_port.h"
#include "model/register_file.h"
#include "model/spec/generated/register_table.h"
#include "selfproj/model/board.h"
#include "selfproj/model/verdict.h"

namespace selfproj::driver {

// A register or one of its fields.
struct RegisterPart {
  const spec::Register* in = nullptr;
  const spec::RegisterField* field = nullptr;  // nullptr: the whole word
};

// The part of this name: "size", "size.columns". A register with one field is known by both names. Throws UserError.
RegisterPart register_part(std::string_view name);

// For one thread at a time. Every error is a UserError that begins with the URI.
class Control {
 public:
  // Reads what the board is. Throws if nothing answers, if it is no selfproj board, or if it was built from another
  // specification.
  explicit Control(std::unique_ptr<RegisterPort> port);

  [[nodiscard]] const model::BoardBuild& build() const { return build_; }

  // Throws UserError if the board's beats cannot have so many columns.
  void need_columns(int columns) const;
  [[nodiscard]] const std::string& uri() const { return port_->uri(); }

  // The value of a register or field.
  [[nodiscard]] std::uint32_t read(std::string_view name) { return read(register_part(name)); }
  [[nodiscard]] std::uint32_t read(const RegisterPart& part);

  // Writes a register, or one of its fields and leaves the others. Throws if the board refuses the value: it then says
  // so, or the register does not hold it afterwards.
  void write(std::string_view name, std::uint32_t value) { write(register_part(name), value); }
  void write(const RegisterPart& part, std::uint32_t value);

  // Writes parts that take effect at one frame start, in the order of their addresses, except that `control` comes
  // last; while they are written, control.hold is 1. Checks first that every value fits its part. If the board refuses
  // one, the earlier ones stay written, and the error names the refused one.
  void write_together(std::vector<std::pair<RegisterPart, std::uint32_t>> values);

  // Writes all settings. They count from the next frame start on, those of the verdict from the next part on. Verdicts
  // need their limits (set_limits) before, and set_ejector.
  void set(const model::BoardSettings& settings);

  // Writes all sections of a bank, which may be fewer than the board has. While verdicts are on, the board refuses this
  // for a bank that judges or is named by the settings. Every write is confirmed by the board.
  void set_limits(int bank, std::span<const model::SectionLimits> sections);

  // The pulse for the ejector, in counts of the encoder: how far behind the first bad frame of a part it begins, and
  // how long it is.
  void set_ejector(std::uint32_t delay, std::uint32_t length);

  // Writes of all settings those of the verdict. They count from the next part on, `verdict` and `verdict_packets` from
  // the next frame start on that takes settings over.
  void set_verdict(const model::BoardSettings& settings);

  // Frames count patterns: frame k from now on has the pattern index k mod patterns, 1..256.
  void count_patterns_on_frames(int patterns);

  // Everything that only the board changes, read register by register; the time as one number.
  [[nodiscard]] model::BoardState state();

  // The value of a part in a word of its register: the threshold of pixels of more than 8 bits whole. Whether a part
  // is only the upper bits of another one.
  [[nodiscard]] std::uint32_t value_in(std::uint32_t word, const RegisterPart& part) const;
  [[nodiscard]] static bool is_in_another(const RegisterPart& part);

 private:
  void write_word(const spec::Register& one, std::uint32_t value);
  void need(const spec::Register& one) const;
  [[nodiscard]] bool in_two_fields(const RegisterPart& part) const;
  [[nodiscard]] std::uint32_t word_with(std::uint32_t word, const RegisterPart& part, std::uint32_t value) const;

  std::unique_ptr<RegisterPort> port_;
  model::BoardBuild build_;
};

// The bits of a word.
constexpr std::uint32_t field_of(std::uint32_t word, int lsb, int bits) {
  return static_cast<std::uint32_t>((word >> lsb) & ((std::uint64_t{1} << bits) - 1));
}

// The URI of the control that belongs to a device (selfproj/driver/device.h); empty if the device has none, as
// recordings and rings have none. For udp:HOST:PORT, which has the port of the packets, it is udp:HOST.
std::string control_uri(const std::string& uri);

// Opens the control of a board by URI:
//
//     udp:HOST[:PORT]     a board on the network (etherbone.h); PORT is that of Etherbone, 1234 unless given
//     bar:PATH[+OFFSET]   registers in a file mapped into memory: /dev/xdma0_user, /dev/uio0, a PCI resource
//     litepcie:PATH       a board behind LitePCIe's kernel driver: /dev/litepcie0 (litepcie.h)
//     file:PATH           the control beside a streaming device: /dev/xdma0_user of /dev/xdma0_c2h_0
//     sim:                inside selfproj-sim only
//
// Throws UserError with the URI if it is none of the above, or if no board of this specification answers there.
std::unique_ptr<Control> open_control(const std::string& uri);

}  // namespace selfproj::driver

#endif  // SELFPROJ_HOST_DRIVER_CONTROL_H
