// A world for live captures: Aravis' fake GigE camera looks at a scene that the pattern of a virtual display lights.
// Nothing here knows the code under test: the camera is on a network, and the pattern is read from the frame buffer.
#ifndef SELFPROJ_TESTS_HOST_CAPTURE_LIVE_WORLD_H
#define SELFPROJ_TESTS_HOST_CAPTURE_LIVE_WORLD_H

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "host/images/image_files.h"
#include "selfproj/images/float_image.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/scene.h"
#include "tests/cli/program.h"
#include "tests/host/camera/gige_camera.h"
#include "tests/host/capture/small_scanner.h"
#include "tests/support/random_cases.h"
#include "tests/support/virtual_screen.h"

namespace selfproj::test {

// How the projector and the network behave.
struct WorldFaults {
  int min_delay_ms = 0;  // from the frame buffer to the light, at random for each picture
  int max_delay_ms = 0;
  double lost = 0;   // share of network packets
  int tick_ms = 10;  // of the camera: it takes a triggered image at the next tick
  double gain = 1;   // of the camera
  double bend = 1;   // of the camera: grey = 255 (light / 255)^bend
  double gamma = 1;  // of the projector: light = (grey / 255)^gamma
  // Tearing: so many per cent of the pictures first appear in part. Of every other one the lower part is still the old
  // picture; the rest are half the old picture and half the new one, as in an exposure across the change.
  int torn_percent = 0;
  int torn_ms = 0;          // for so long
  bool same_noise = false;  // each time that a pattern is seen
  std::uint64_t seed = 1;
};

class LiveWorld {
 public:
  using Clock = std::chrono::steady_clock;

  LiveWorld(const rig::Rig& rig, const sim::Scene& scene, const VirtualScreen& screen, const WorldFaults& faults)
      : rig_(rig),
        actual_(rig),
        renderer_(std::make_shared<sim::PatternRenderer>(actual_, scene, sim::RenderOptions{}, 1)),
        screen_(screen),
        faults_(faults),
        random_(faults.seed),
        look_([this] { look(); }),
        camera_([this](const Picture& picture) { draw(picture); }, faults.lost, faults.tick_ms) {}
  LiveWorld(const LiveWorld&) = delete;
  LiveWorld& operator=(const LiveWorld&) = delete;
  ~LiveWorld() {
    done_ = true;
    look_.join();
  }

  // Puts another scene before the camera.
  void look_at(const sim::Scene& scene) {
    auto renderer = std::make_shared<sim::PatternRenderer>(actual_, scene, sim::RenderOptions{}, 1);
    const std::lock_guard lock(mutex_);
    renderer_ = std::move(renderer);
  }

  // Covers the camera's lens.
  void put_cap_on() { capped_ = true; }

  // z in mm of what each pixel sees.
  [[nodiscard]] std::vector<float> truth() const {
    std::vector<float> z(rig_.camera.pixels());
    renderer_->depth(0, z);
    return z;
  }

  // The same, but NaN where the projector's light does not come.
  [[nodiscard]] images::FloatImage lit() const {
    images::FloatImage z(rig_.camera.rows, rig_.camera.columns);
    renderer_->lit_depth(0, z.values);
    return z;
  }

  // How late this world noticed a picture at most, by the longest time between two looks.
  [[nodiscard]] double look_ms() const { return look_ms_; }

  // The longest time between two images that the camera took.
  [[nodiscard]] double image_ms() const { return image_ms_; }

  // How many pictures have been torn.
  [[nodiscard]] int torn() const { return torn_; }

  // The image under a pattern, without display, camera and network.
  [[nodiscard]] images::Image image_under(const images::Image& pattern) const {
    images::Image image{rig_.camera.rows, rig_.camera.columns, std::vector<std::uint8_t>(rig_.camera.pixels())};
    renderer_->render(noise_of(pattern.pixels), sim::project_image(rig_, pattern, renderer_->options()),
                      std::span(image.pixels));
    return image;
  }

 private:
  // The frame whose noise the image under a pattern has.
  [[nodiscard]] int noise_of(const std::vector<std::uint8_t>& pattern) const {
    const std::string_view bytes(reinterpret_cast<const char*>(pattern.data()), pattern.size());
    return faults_.same_noise ? static_cast<int>(std::hash<std::string_view>{}(bytes) % 100'000) : 0;
  }

  struct Shown {
    Clock::time_point lit;
    std::vector<std::uint8_t> pixels;
  };

  // Notes every new picture on the display, and when it will be light.
  void look() {
    std::vector<std::uint8_t> last;
    Clock::time_point newest = Clock::now();
    Clock::time_point before = Clock::now();
    while (!done_) {
      const std::chrono::duration<double, std::milli> since = Clock::now() - std::exchange(before, Clock::now());
      look_ms_ = std::max(look_ms_.load(), since.count());
      std::vector<std::uint8_t> now = screen_.picture();
      if (now != last && now == screen_.picture()) {  // no picture that is just being drawn
        const std::chrono::milliseconds delay(random_.between(faults_.min_delay_ms, faults_.max_delay_ms));
        newest = std::max(newest, Clock::now() + delay);
        const bool torn = !last.empty() && random_.between(1, 100) <= faults_.torn_percent;
        const std::lock_guard lock(mutex_);
        if (torn) {
          shown_.push_back(
              {newest, torn_++ % 2 == 0 ? torn_below(last, now, random_.between(10, 90)) : torn_across(last, now)});
          newest += std::chrono::milliseconds(faults_.torn_ms);
        }
        last = now;
        shown_.push_back({newest, std::move(now)});
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }

  void draw(const Picture& picture) {
    const std::chrono::duration<double, std::milli> since = Clock::now() - std::exchange(last_image_, Clock::now());
    image_ms_ = picture.number > 0 ? std::max(image_ms_.load(), since.count()) : 0;
    if (capped_ || picture.rows != rig_.camera.rows || picture.columns != rig_.camera.columns) {
      std::fill_n(picture.pixels, picture.rows * picture.columns, std::uint8_t{0});
      return;
    }
    bool changed = false;
    std::shared_ptr<const sim::PatternRenderer> renderer;
    {
      const std::lock_guard lock(mutex_);
      renderer = renderer_;
      while (shown_.size() > 1 && shown_[1].lit <= Clock::now()) {
        shown_.pop_front();
      }
      changed = !shown_.empty() && light_pixels_ != shown_.front().pixels && shown_.front().lit <= Clock::now();
      if (changed) {
        light_pixels_ = shown_.front().pixels;
      }
    }
    if (changed || !light_) {
      images::Image pattern{rig_.projector.lines, rig_.projector.columns, light_pixels_};
      pattern.pixels.resize(static_cast<std::size_t>(pattern.rows) * static_cast<std::size_t>(pattern.columns));
      for (std::uint8_t& pixel : pattern.pixels) {
        pixel = static_cast<std::uint8_t>(std::lround(255 * std::pow(pixel / 255.0, faults_.gamma)));
      }
      light_ = std::make_unique<sim::ProjectedLight>(sim::project_image(rig_, pattern, renderer->options()));
    }
    const std::span<std::uint8_t> pixels(picture.pixels, rig_.camera.pixels());
    const int frame = faults_.same_noise ? noise_of(light_pixels_) : static_cast<int>(picture.number % 100'000);
    renderer->render(frame, *light_, pixels);
    if (faults_.gain != 1 || faults_.bend != 1) {
      for (std::uint8_t& pixel : pixels) {
        pixel = static_cast<std::uint8_t>(255 * std::pow(std::min(1.0, pixel * faults_.gain / 255), faults_.bend));
      }
    }
  }

  rig::Rig rig_;
  sim::PerturbedRig actual_;
  std::shared_ptr<const sim::PatternRenderer> renderer_;
  const VirtualScreen& screen_;
  WorldFaults faults_;
  Random random_;
  std::mutex mutex_;
  std::deque<Shown> shown_;
  std::vector<std::uint8_t> light_pixels_;  // only the camera's thread
  std::unique_ptr<sim::ProjectedLight> light_;
  std::atomic<bool> done_ = false;
  std::atomic<bool> capped_ = false;
  std::atomic<double> look_ms_ = 0;
  std::atomic<double> image_ms_ = 0;
  Clock::time_point last_image_;
  std::atomic<int> torn_ = 0;
  std::thread look_;
  GigeCamera camera_;
};

// A test with a display and a network of its own. What a world shows must outlive it.
class LiveTest : public OnOwnNetwork {
 protected:
  explicit LiveTest(rig::Rig rig) : rig_(std::move(rig)) {}

  void SetUp() override {
    if (!VirtualScreen::installed()) {
      GTEST_SKIP() << "Xvfb is not installed";
    }
    OnOwnNetwork::SetUp();
    if (!IsSkipped()) {
      screen_ = std::make_unique<VirtualScreen>(rig_.projector.columns, rig_.projector.lines, screen_folder_.path());
      prepare();
    }
  }
  void TearDown() override { world_.reset(); }

  virtual void prepare() = 0;

  void look(const sim::Scene& scene, const WorldFaults& faults) {
    world_ = std::make_unique<LiveWorld>(rig_, scene, *screen_, faults);
  }

  [[nodiscard]] Outcome run(const std::vector<std::string>& arguments) const {
    return run_program(SELFPROJ_PROGRAM, arguments, folder_.path());
  }

  rig::Rig rig_;
  ScratchFolder screen_folder_;
  ScratchFolder folder_;
  std::unique_ptr<VirtualScreen> screen_;
  std::unique_ptr<LiveWorld> world_;
};

// How far depths are from the truth.
struct DepthErrors {
  std::size_t pixels = 0;
  double median_mm = 0;
};

inline DepthErrors depth_errors(const std::filesystem::path& file, const std::vector<float>& truth) {
  const images::FloatImage z = images::read_float_tiff(file.string());
  std::vector<double> off;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (!std::isnan(z.values[i]) && !std::isnan(truth[i])) {
      off.push_back(std::abs(static_cast<double>(z.values[i]) - static_cast<double>(truth[i])));
    }
  }
  std::sort(off.begin(), off.end());
  return {off.size(), off.empty() ? 1e9 : off[off.size() / 2]};
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_HOST_CAPTURE_LIVE_WORLD_H
