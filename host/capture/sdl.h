// The functions of SDL2 that projectors use. The library is loaded when the first projector opens: it needs fifty
// others, for which the loader would take as long as for the rest of the program.
#ifndef SELFPROJ_HOST_CAPTURE_SDL_H
#define SELFPROJ_HOST_CAPTURE_SDL_H

#define SDL_MAIN_HANDLED
#include <SDL.h>

namespace selfproj {

struct Sdl {
  decltype(&SDL_Init) init;
  decltype(&SDL_QuitSubSystem) quit;
  decltype(&SDL_SetHint) set_hint;
  decltype(&SDL_GetError) error;
  decltype(&SDL_GetNumVideoDisplays) displays;
  decltype(&SDL_GetDisplayName) display_name;
  decltype(&SDL_GetDisplayBounds) display_bounds;
  decltype(&SDL_GetCurrentDisplayMode) display_mode;
  decltype(&SDL_CreateWindow) create_window;
  decltype(&SDL_DestroyWindow) destroy_window;
  decltype(&SDL_GetWindowSurface) window_surface;
  decltype(&SDL_UpdateWindowSurface) update_surface;
  decltype(&SDL_LockSurface) lock_surface;
  decltype(&SDL_UnlockSurface) unlock_surface;
  decltype(&SDL_MapRGB) map_rgb;
  decltype(&SDL_ShowCursor) show_cursor;
  decltype(&SDL_PollEvent) poll_event;
};

// Throws UserError if the library cannot be loaded.
const Sdl& sdl();

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CAPTURE_SDL_H
