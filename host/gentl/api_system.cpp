// The functions of the library, the system and the interface.
#include <cstring>
#include <memory>

#include "host/gentl/answer.h"
#include "host/gentl/gentl_errors.h"
#include "host/gentl/gentl_types.h"
#include "host/gentl/library.h"
#include "host/gentl/system.h"

// Functions with the linkage of C are the same in every namespace.
namespace selfproj::gentl {

// NOLINTBEGIN(readability-identifier-naming): names of the standard

GC_API GCGetInfo(TL_INFO_CMD iInfoCmd, INFO_DATATYPE* piType, void* pBuffer, std::size_t* piSize) {
  return guarded([&] { give_producer_info(iInfoCmd, {piType, pBuffer, piSize}); });
}

// Errors of this function do not replace the error that it tells.
GC_API GCGetLastError(GC_ERROR* piErrorCode, char* sErrorText, std::size_t* piSize) {
  if (piErrorCode == nullptr || piSize == nullptr) {
    return GC_ERR_INVALID_PARAMETER;
  }
  *piErrorCode = last_error_code();
  const std::size_t bytes = std::strlen(last_error_text()) + 1;
  if (sErrorText != nullptr) {
    if (*piSize < bytes) {
      return GC_ERR_BUFFER_TOO_SMALL;
    }
    std::memcpy(sErrorText, last_error_text(), bytes);
  }
  *piSize = bytes;
  return GC_ERR_SUCCESS;
}

GC_API GCInitLib() {
  return guarded([] {
    const std::lock_guard lock(library().mutex);
    require(!library().initialized, GC_ERR_RESOURCE_IN_USE, "GCInitLib was called already");
    library().initialized = true;
  });
}

GC_API GCCloseLib() {
  return call([] {
    close_system();
    library().initialized = false;
  });
}

GC_API TLOpen(TL_HANDLE* phSystem) {
  return call([&] {
    require_pointer(phSystem);
    require(library().system == nullptr, GC_ERR_RESOURCE_IN_USE, "the system is open already");
    library().system = std::make_shared<System>();
    give_handle(library().system);
    *phSystem = library().system->handle;
  });
}

GC_API TLClose(TL_HANDLE hSystem) {
  return call([&] {
    find<System>(hSystem);
    close_system();
  });
}

GC_API TLGetInfo(TL_HANDLE hSystem, TL_INFO_CMD iInfoCmd, INFO_DATATYPE* piType, void* pBuffer, std::size_t* piSize) {
  return call([&] {
    find<System>(hSystem);
    give_producer_info(iInfoCmd, {piType, pBuffer, piSize});
  });
}

GC_API TLGetNumInterfaces(TL_HANDLE hSystem, std::uint32_t* piNumIfaces) {
  return call([&] {
    find<System>(hSystem);
    require_pointer(piNumIfaces);
    *piNumIfaces = 1;
  });
}

GC_API TLGetInterfaceID(TL_HANDLE hSystem, std::uint32_t iIndex, char* sID, std::size_t* piSize) {
  return call([&] {
    find<System>(hSystem);
    require(iIndex == 0, GC_ERR_INVALID_INDEX, "there is one interface");
    give(kInterfaceId, {nullptr, sID, piSize});
  });
}

GC_API TLGetInterfaceInfo(TL_HANDLE hSystem, const char* sIfaceID, INTERFACE_INFO_CMD iInfoCmd, INFO_DATATYPE* piType,
                          void* pBuffer, std::size_t* piSize) {
  return call([&] {
    find<System>(hSystem);
    require_pointer(sIfaceID);
    require(std::strcmp(sIfaceID, kInterfaceId) == 0, GC_ERR_INVALID_ID, "there is no such interface");
    give_interface_info(iInfoCmd, {piType, pBuffer, piSize});
  });
}

GC_API TLOpenInterface(TL_HANDLE hSystem, const char* sIfaceID, IF_HANDLE* phIface) {
  return call([&] {
    const auto system = find<System>(hSystem);
    require_pointer(phIface);
    *phIface = system->open(sIfaceID)->handle;
  });
}

GC_API TLUpdateInterfaceList(TL_HANDLE hSystem, bool8_t* pbChanged, std::uint64_t /*iTimeout*/) {
  return call([&] {
    find<System>(hSystem);
    if (pbChanged != nullptr) {
      *pbChanged = 0;
    }
  });
}

GC_API IFClose(IF_HANDLE hIface) {
  return call([&] {
    find<Interface>(hIface);
    library().system->close_interface();
  });
}

GC_API IFGetInfo(IF_HANDLE hIface, INTERFACE_INFO_CMD iInfoCmd, INFO_DATATYPE* piType, void* pBuffer,
                 std::size_t* piSize) {
  return call([&] {
    find<Interface>(hIface);
    give_interface_info(iInfoCmd, {piType, pBuffer, piSize});
  });
}

GC_API IFGetParentTL(IF_HANDLE hIface, TL_HANDLE* phSystem) {
  return call([&] {
    const auto interface = find<Interface>(hIface);
    require_pointer(phSystem);
    *phSystem = interface->parent();
  });
}

GC_API IFUpdateDeviceList(IF_HANDLE hIface, bool8_t* pbChanged, std::uint64_t /*iTimeout*/) {
  return call([&] {
    const bool changed = find<Interface>(hIface)->update();
    if (pbChanged != nullptr) {
      *pbChanged = changed ? 1 : 0;
    }
  });
}

GC_API IFGetNumDevices(IF_HANDLE hIface, std::uint32_t* piNumDevices) {
  return call([&] {
    const auto interface = find<Interface>(hIface);
    require_pointer(piNumDevices);
    *piNumDevices = static_cast<std::uint32_t>(interface->devices().size());
  });
}

GC_API IFGetDeviceID(IF_HANDLE hIface, std::uint32_t iIndex, char* sIDeviceID, std::size_t* piSize) {
  return call([&] {
    const auto interface = find<Interface>(hIface);
    require(iIndex < interface->devices().size(), GC_ERR_INVALID_INDEX, "there are fewer devices");
    give(interface->devices()[iIndex].id, {nullptr, sIDeviceID, piSize});
  });
}

GC_API IFGetDeviceInfo(IF_HANDLE hIface, const char* sDeviceID, DEVICE_INFO_CMD iInfoCmd, INFO_DATATYPE* piType,
                       void* pBuffer, std::size_t* piSize) {
  return call([&] {
    const auto interface = find<Interface>(hIface);
    const DeviceEntry& entry = interface->entry(sDeviceID);
    give_device_info(entry, interface->opened(entry.id).get(), iInfoCmd, {piType, pBuffer, piSize});
  });
}

GC_API IFOpenDevice(IF_HANDLE hIface, const char* sDeviceID, DEVICE_ACCESS_FLAGS iOpenFlags, DEV_HANDLE* phDevice) {
  return call([&] {
    const auto interface = find<Interface>(hIface);
    require_pointer(phDevice);
    *phDevice = interface->open(sDeviceID, iOpenFlags)->handle;
  });
}

// NOLINTEND(readability-identifier-naming)

}  // namespace selfproj::gentl
