// The functions of <opencv2/imgcodecs.hpp> that this project uses. Each loads OpenCV's library of image codecs when it
// is first called, and hands the call on.
//
// Debian's library of image codecs needs a hundred other libraries (GDAL and what it reads). The loader takes 65 ms of
// processor time for them, six times as long as for everything else of a program that prints its help, refuses an
// option or reads packets.

#include <dlfcn.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "selfproj/files/user_error.h"

namespace {

void* library() {
  // Lazily, like the loader itself does when a program starts.
  static void* const loaded = dlopen(SELFPROJ_IMAGE_CODECS, RTLD_LAZY | RTLD_LOCAL);
  if (loaded == nullptr) {
    const char* reason = dlerror();
    throw selfproj::UserError("OpenCV's image codecs", reason != nullptr ? reason : SELFPROJ_IMAGE_CODECS);
  }
  return loaded;
}

// The function of the library that the linker knows by this name.
template <typename Function>
Function* codec(const char* name) {
  void* const found = dlsym(library(), name);
  if (found == nullptr) {
    throw selfproj::UserError("OpenCV's image codecs", std::string("have no function ") + name);
  }
  return reinterpret_cast<Function*>(found);
}

}  // namespace

namespace cv {

Mat imread(const String& filename, int flags) {
  static auto* const real =
      codec<Mat(const String&, int)>("_ZN2cv6imreadERKNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEEi");
  return real(filename, flags);
}

Mat imdecode(InputArray buf, int flags) {
  static auto* const real = codec<Mat(InputArray, int)>("_ZN2cv8imdecodeERKNS_11_InputArrayEi");
  return real(buf, flags);
}

bool imwrite(const String& filename, InputArray img, const std::vector<int>& params) {
  static auto* const real = codec<bool(const String&, InputArray, const std::vector<int>&)>(
      "_ZN2cv7imwriteERKNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEERKNS_11_InputArrayERKSt6vectorIiSaIiEE");
  return real(filename, img, params);
}

bool imencode(const String& ext, InputArray img, std::vector<uchar>& buf, const std::vector<int>& params) {
  static auto* const real = codec<bool(const String&, InputArray, std::vector<uchar>&, const std::vector<int>&)>(
      "_ZN2cv8imencodeERKNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEERKNS_11_InputArrayERSt6vectorIhSaIhEE"
      "RKSB_IiSaIiEE");
  return real(ext, img, buf, params);
}

}  // namespace cv
