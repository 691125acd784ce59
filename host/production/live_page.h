// A page on which a production can be watched with a browser.
#ifndef SELFPROJ_HOST_PRODUCTION_LIVE_PAGE_H
#define SELFPROJ_HOST_PRODUCTION_LIVE_PAGE_H

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "host/production/camera_view.h"
#include "host/production/cutter.h"
#include "host/production/endpoint.h"
#include "host/production/newest.h"
#include "host/production/part_result.h"
#include "host/report/facts.h"
#include "selfproj/images/float_image.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/rig.h"

namespace selfproj::production {

// Serves, read only, by HTTP
//   /         the page, its script and its style; three.js of this machine. Nothing comes from anywhere else
//   /stream   what there is to see, kPerSecond times a second at most, in chunks without end. Each message is
//                 bytes of the JSON, 32 bits, little endian; bytes of the floats, likewise; JSON; floats
//             where the floats of kind `profiles` are the newest profile (y, height, difference of each column) and
//             `rows` rows of differences since the last message, and those of kind `depth` the differences of the
//             newest depth image, every n-th of rows x columns; all mm
//   /part     the last part's placed maps: the same form; floats are height, then difference
//   /camera   the newest raw image that came while somebody watched: the same form; in the place of the floats are the
//             row of the line in each column (none for a scanner), and then the image's bytes, every n-th pixel
//
// A browser gets the newest message when it has received the one before. Messages in between are dropped for it and
// counted. The production's thread only makes messages, and only while somebody watches. It and the thread that takes
// packets never wait for the thread that serves.
//
// On a loopback address, requests must be for a name of this machine. On any other, they need a token, which is drawn
// at the start and is part of url().
class LivePage {
 public:
  static constexpr int kPerSecond = 20;
  static constexpr std::size_t kPartsShown = 20;

  // Throws UserError about --live if it cannot listen there. `title` stands above the page.
  LivePage(const Endpoint& endpoint, const rig::Rig& rig, const std::string& title);
  LivePage(const LivePage&) = delete;
  LivePage& operator=(const LivePage&) = delete;
  ~LivePage();

  // For the thread of the production: a profile or a depth image, and a part with the statistics up to it.
  void measured(MeasuredFrame& measured);
  void part(const PartResult& result, const PlacedMaps& maps, const PartStatistics& statistics);

  // For the thread that takes packets: a raw image, and the row of the line in each column (empty for a scanner).
  void camera(const model::PacketHeader& header, const model::ImageView& image, const std::vector<float>& line,
              const ExposureFigures& exposure);

  // Whether anybody watches.
  [[nodiscard]] bool watched() const { return watchers_ > 0; }

  // For the thread that takes packets: the figures that the page shows.
  void report(const std::vector<report::Fact>& figures);

  // Where a browser finds it.
  [[nodiscard]] std::string url() const;

  // Messages that were dropped for slow browsers.
  [[nodiscard]] std::uint64_t dropped() const { return dropped_; }

 private:
  class Server;
  struct Message {
    std::uint64_t number = 0;
    std::shared_ptr<const std::string> bytes;
  };

  // The newest message after `number`, which it raises; null if there is none.
  std::shared_ptr<const std::string> next_message(std::uint64_t& number);
  std::shared_ptr<const std::string> last_part();
  std::shared_ptr<const std::string> last_image();
  void profile(const light_section::ProfileView& profile);
  void depth(const images::FloatImage& difference);
  void add_row(const light_section::ProfileView& profile);
  bool message_is_due();
  void send(const std::string& kind, int rows, int columns, const std::string& floats);

  Endpoint endpoint_;
  int columns_;
  double plane_z_;
  std::string title_;
  std::string token_;
  std::atomic<std::size_t> watchers_{0};
  std::atomic<std::uint64_t> dropped_{0};
  std::atomic<std::uint64_t> camera_images_{0};
  Newest<std::string> new_figures_;
  Newest<Message> new_message_;
  Newest<const std::string> new_part_;
  Newest<const std::string> new_camera_;

  // Of the production's thread:
  std::int64_t next_message_ns_ = 0;
  std::int64_t next_row_ns_ = 0;
  std::vector<float> rows_;
  std::uint64_t messages_ = 0;
  std::string figures_ = "{}";
  std::deque<std::string> parts_;  // JSON, the newest first
  std::string statistics_ = "{}";

  // Of the server's thread:
  Message message_;
  std::shared_ptr<const std::string> part_;
  std::shared_ptr<const std::string> camera_;
  std::unique_ptr<Server> server_;
};

}  // namespace selfproj::production

#endif  // SELFPROJ_HOST_PRODUCTION_LIVE_PAGE_H
