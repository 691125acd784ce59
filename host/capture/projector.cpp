#include "host/capture/projector.h"

#define SDL_MAIN_HANDLED
#include <SDL.h>
#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "selfproj/files/user_error.h"

namespace selfproj::capture {
namespace {

// SDL2, which is loaded when the first projector opens: it needs fifty other libraries, for which the loader would take
// as long as for the rest of the program. Throws UserError if it cannot be loaded.
void* sdl_library() {
  constexpr const char* kLibrary = "libSDL2-2.0.so.0";
  static void* const loaded = dlopen(kLibrary, RTLD_LAZY | RTLD_LOCAL);
  if (loaded == nullptr) {
    const char* const reason = dlerror();
    throw UserError("SDL2, which opens displays", reason != nullptr ? reason : kLibrary);
  }
  return loaded;
}

template <class Function>
Function sdl_function(const char* name) {
  void* const found = dlsym(sdl_library(), name);
  if (found == nullptr) {
    throw UserError("SDL2, which opens displays", std::string("has no function ") + name);
  }
  return reinterpret_cast<Function>(found);
}

// A function of SDL2, which its headers declare: SDL2(SDL_Init)(SDL_INIT_VIDEO).
#define SDL2(name) sdl_function<decltype(&(name))>(#name)

// Opens SDL's video for its own lifetime. SDL handles no signals, and no graphics processor scales or draws the images.
class Video {
 public:
  Video() {
    for (const char* hint : {"SDL_NO_SIGNAL_HANDLERS", "SDL_VIDEO_X11_NET_WM_BYPASS_COMPOSITOR"}) {
      SDL2(SDL_SetHint)(hint, "1");
    }
    SDL2(SDL_SetHint)(SDL_HINT_FRAMEBUFFER_ACCELERATION, "0");
    // Only drivers of real screens. Where there is no Wayland, its library would complain on standard error.
    SDL2(SDL_SetHint)(SDL_HINT_VIDEODRIVER, std::getenv("WAYLAND_DISPLAY") != nullptr ? "x11,wayland" : "x11,KMSDRM");
    open_ = SDL2(SDL_Init)(SDL_INIT_VIDEO) == 0;
  }
  Video(const Video&) = delete;
  Video& operator=(const Video&) = delete;
  ~Video() {
    if (open_) {
      SDL2(SDL_QuitSubSystem)(SDL_INIT_VIDEO);
    }
  }

  [[nodiscard]] bool open() const { return open_; }

 private:
  bool open_ = false;
};

DisplayEntry entry_of(int number) {
  SDL_Rect bounds{};
  SDL_DisplayMode mode{};
  const char* const name = SDL2(SDL_GetDisplayName)(number);
  static_cast<void>(SDL2(SDL_GetDisplayBounds)(number, &bounds));
  static_cast<void>(SDL2(SDL_GetCurrentDisplayMode)(number, &mode));
  return {.number = number,
          .name = name != nullptr ? name : "",
          .columns = bounds.w,
          .rows = bounds.h,
          .rate_hz = static_cast<double>(mode.refresh_rate)};
}

struct WindowCloser {
  void operator()(SDL_Window* window) const { SDL2(SDL_DestroyWindow)(window); }
};

}  // namespace

std::vector<DisplayEntry> list_displays() {
  const Video video;
  std::vector<DisplayEntry> displays;
  const int count = video.open() ? SDL2(SDL_GetNumVideoDisplays)() : 0;
  for (int i = 0; i < count; ++i) {
    displays.push_back(entry_of(i));
  }
  return displays;
}

GreyTable plain_greys() {
  GreyTable greys{};
  std::iota(greys.begin(), greys.end(), std::uint8_t{0});
  return greys;
}

struct Projector::Parts {
  std::string what;  // "--display 1"
  Video video;
  std::unique_ptr<SDL_Window, WindowCloser> window;
  GreyTable greys{};
  images::Image shown;
  bool stopped = false;

  [[noreturn]] void fail(const std::string& reason) const { throw UserError(what, reason); }

  // The window's pixels. SDL makes another surface after each change of the window's size.
  [[nodiscard]] SDL_Surface* surface() const {
    SDL_Surface* const pixels = SDL2(SDL_GetWindowSurface)(window.get());
    if (pixels == nullptr || pixels->format->BytesPerPixel != 4) {
      fail(fmt::format("cannot be drawn on: {}",
                       pixels == nullptr ? SDL2(SDL_GetError)() : "it does not have 24-bit colour"));
    }
    return pixels;
  }

  void draw() const {
    SDL_Surface* const pixels = surface();
    if (pixels->w != shown.columns || pixels->h != shown.rows) {
      fail(fmt::format("the window has {} x {} pixels, not the {} x {} of the display", pixels->w, pixels->h,
                       shown.columns, shown.rows));
    }
    std::array<std::uint32_t, 256> colours;
    for (std::size_t grey = 0; grey < colours.size(); ++grey) {
      const std::uint8_t level = greys[grey];
      colours[grey] = SDL2(SDL_MapRGB)(pixels->format, level, level, level);
    }
    if (SDL_MUSTLOCK(pixels) && SDL2(SDL_LockSurface)(pixels) != 0) {
      fail(fmt::format("cannot be drawn on: {}", SDL2(SDL_GetError)()));
    }
    std::vector<std::uint32_t> line(static_cast<std::size_t>(shown.columns));
    for (int row = 0; row < shown.rows; ++row) {
      const std::uint8_t* const from = shown.pixels.data() + static_cast<std::ptrdiff_t>(row) * shown.columns;
      std::transform(from, from + shown.columns, line.begin(), [&](std::uint8_t grey) { return colours[grey]; });
      std::memcpy(static_cast<std::uint8_t*>(pixels->pixels) + static_cast<std::ptrdiff_t>(row) * pixels->pitch,
                  line.data(), line.size() * sizeof line[0]);
    }
    if (SDL_MUSTLOCK(pixels)) {
      SDL2(SDL_UnlockSurface)(pixels);
    }
    if (SDL2(SDL_UpdateWindowSurface)(window.get()) != 0) {
      fail(fmt::format("cannot be drawn on: {}", SDL2(SDL_GetError)()));
    }
  }

  void handle_events() {
    SDL_Event event;
    bool uncovered = false;
    while (SDL2(SDL_PollEvent)(&event) != 0) {
      const bool escape = event.type == SDL_KEYDOWN && event.key.keysym.sym == SDLK_ESCAPE;
      stopped = stopped || escape || event.type == SDL_QUIT;
      uncovered = uncovered || (event.type == SDL_WINDOWEVENT && event.window.event == SDL_WINDOWEVENT_EXPOSED);
    }
    if (uncovered) {
      draw();
    }
  }
};

Projector::Projector(int display, const GreyTable& greys) : parts_(std::make_unique<Parts>()) {
  parts_->what = fmt::format("--display {}", display);
  parts_->greys = greys;
  if (!parts_->video.open()) {
    parts_->fail(fmt::format("no screen can be reached: {}", SDL2(SDL_GetError)()));
  }
  const int count = SDL2(SDL_GetNumVideoDisplays)();
  if (display < 0 || display >= count) {
    parts_->fail(count == 1 ? "there is no such display, only display 0"
                            : fmt::format("there is no such display, only 0 to {}", count - 1));
  }
  SDL_Rect bounds{};
  static_cast<void>(SDL2(SDL_GetDisplayBounds)(display, &bounds));
  parts_->window.reset(SDL2(SDL_CreateWindow)("selfproj", bounds.x, bounds.y, bounds.w, bounds.h,
                                              SDL_WINDOW_FULLSCREEN_DESKTOP | SDL_WINDOW_BORDERLESS));
  if (!parts_->window) {
    parts_->fail(fmt::format("cannot be opened: {}", SDL2(SDL_GetError)()));
  }
  static_cast<void>(SDL2(SDL_ShowCursor)(SDL_DISABLE));
  parts_->shown = {bounds.h, bounds.w, {}};
  show(std::uint8_t{0});
}

Projector::~Projector() {
  try {
    show(std::uint8_t{0});
  } catch (const UserError&) {  // a display that has gone shows nothing
  }
}

int Projector::rows() const { return parts_->shown.rows; }
int Projector::columns() const { return parts_->shown.columns; }

void Projector::show(const images::Image& pattern, const std::string& name) {
  if (pattern.rows != rows() || pattern.columns != columns()) {
    throw UserError(name, fmt::format("has {} x {} pixels, but {} has {} x {}", pattern.columns, pattern.rows,
                                      parts_->what, columns(), rows()));
  }
  parts_->shown.pixels = pattern.pixels;
  parts_->handle_events();
  parts_->draw();
}

void Projector::show(std::uint8_t grey) {
  const std::size_t pixels = static_cast<std::size_t>(rows()) * static_cast<std::size_t>(columns());
  show(images::Image{rows(), columns(), std::vector<std::uint8_t>(pixels, grey)}, parts_->what);
}

bool Projector::stopped() {
  parts_->handle_events();
  return parts_->stopped;
}

}  // namespace selfproj::capture
