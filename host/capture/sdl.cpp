#include "host/capture/sdl.h"

#include <dlfcn.h>

#include <string>
#include <type_traits>

#include "host/files/user_error.h"

namespace selfproj {
namespace {

constexpr const char* kLibrary = "libSDL2-2.0.so.0";

Sdl load() {
  void* const library = dlopen(kLibrary, RTLD_LAZY | RTLD_LOCAL);
  if (library == nullptr) {
    const char* const reason = dlerror();
    throw UserError("SDL2, which opens displays", reason != nullptr ? reason : kLibrary);
  }
  const auto find = [&](auto& function, const char* name) {
    void* const found = dlsym(library, name);
    if (found == nullptr) {
      throw UserError("SDL2, which opens displays", std::string("has no function ") + name);
    }
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(found);
  };
  Sdl loaded{};
  find(loaded.init, "SDL_Init");
  find(loaded.quit, "SDL_QuitSubSystem");
  find(loaded.set_hint, "SDL_SetHint");
  find(loaded.error, "SDL_GetError");
  find(loaded.displays, "SDL_GetNumVideoDisplays");
  find(loaded.display_name, "SDL_GetDisplayName");
  find(loaded.display_bounds, "SDL_GetDisplayBounds");
  find(loaded.display_mode, "SDL_GetCurrentDisplayMode");
  find(loaded.create_window, "SDL_CreateWindow");
  find(loaded.destroy_window, "SDL_DestroyWindow");
  find(loaded.window_surface, "SDL_GetWindowSurface");
  find(loaded.update_surface, "SDL_UpdateWindowSurface");
  find(loaded.lock_surface, "SDL_LockSurface");
  find(loaded.unlock_surface, "SDL_UnlockSurface");
  find(loaded.map_rgb, "SDL_MapRGB");
  find(loaded.show_cursor, "SDL_ShowCursor");
  find(loaded.poll_event, "SDL_PollEvent");
  return loaded;
}

}  // namespace

const Sdl& sdl() {
  static const Sdl loaded = load();
  return loaded;
}

}  // namespace selfproj
