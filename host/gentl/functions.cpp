// The functions of the standard, as a consumer calls them.
#include <algorithm>
#include <cstring>
#include <memory>
#include <vector>

#include "host/gentl/answer.h"
#include "host/gentl/event_queue.h"
#include "host/gentl/gentl_types.h"
#include "host/gentl/module.h"
#include "host/gentl/stream.h"
#include "host/gentl/system.h"

namespace selfproj::gentl {
namespace {

// Does the work of a function on the module of a handle.
template <typename Kind, typename Work>
GC_ERROR on(void* handle, const Work& work) {
  return call([&] { work(*find<Kind>(handle)); });
}

// Answers a question about a module by one value.
template <typename Kind, typename Value, typename Get>
GC_ERROR one_value(void* handle, Value* to, const Get& get) {
  return on<Kind>(handle, [&](Kind& module) {
    require_pointer(to);
    *to = get(module);
  });
}

// What functions do with a buffer of a stream: work(stream, buffer, its contents).
template <typename Work>
GC_ERROR on_buffer(DS_HANDLE stream_handle, BUFFER_HANDLE buffer_handle, const Work& work) {
  return call([&] {
    const auto stream = find<Stream>(stream_handle);
    const auto buffer = find<Buffer>(buffer_handle);
    stream->require_own(buffer);
    work(*buffer, stream->contents_of(*buffer));
  });
}

void read_port(void* port, std::uint64_t address, void* to, std::size_t* size) {
  const auto module = library().module(port);
  require_pointer(to);
  require_pointer(size);
  module->features().read(address, {static_cast<std::uint8_t*>(to), *size});
}

void write_port(void* port, std::uint64_t address, const void* from, std::size_t* size) {
  const auto module = library().module(port);
  require_pointer(from);
  require_pointer(size);
  require(module->writable(), GC_ERR_ACCESS_DENIED, "the device is open for reading alone");
  module->features().write(address, {static_cast<const std::uint8_t*>(from), *size});
}

void give_port_info(Module& module, PORT_INFO_CMD command, const Answer& to) {
  switch (command) {
    case PORT_INFO_ID:
      return give(module.id(), to);
    case PORT_INFO_VENDOR:
      return give(kVendor, to);
    case PORT_INFO_MODEL:
      return give(module.model(), to);
    case PORT_INFO_TLTYPE:
      return give(kTransport, to);
    case PORT_INFO_MODULE:
      return give(module.kind(), to);
    case PORT_INFO_LITTLE_ENDIAN:
    case PORT_INFO_ACCESS_READ:
      return give(true, to);
    case PORT_INFO_ACCESS_WRITE:
      return give(module.writable(), to);
    case PORT_INFO_BIG_ENDIAN:
    case PORT_INFO_ACCESS_NA:
    case PORT_INFO_ACCESS_NI:
      return give(false, to);
    case PORT_INFO_VERSION:
      return give(producer_version(), to);
    case PORT_INFO_PORTNAME:
      return give("Device", to);
    default:
      no_answer(command);
  }
}

void give_url_info(Module& module, URL_INFO_CMD command, const Answer& to) {
  FeatureSet& features = module.features();
  switch (command) {
    case URL_INFO_URL:
      return give(features.url(), to);
    case URL_INFO_SCHEMA_VER_MAJOR:
    case URL_INFO_SCHEMA_VER_MINOR:
    case URL_INFO_FILE_VER_MAJOR:
      return give(std::int32_t{1}, to);
    case URL_INFO_FILE_VER_MINOR:
    case URL_INFO_FILE_VER_SUBMINOR:
      return give(std::int32_t{0}, to);
    case URL_INFO_FILE_REGISTER_ADDRESS:
      return give(std::uint64_t{FeatureSet::kXmlAddress}, to);
    case URL_INFO_FILE_SIZE:
      return give(std::uint64_t{features.xml().size()}, to);
    case URL_INFO_SCHEME:
      return give(std::int32_t{URL_SCHEME_LOCAL}, to);
    case URL_INFO_FILENAME:
      return give(features.name().model + ".xml", to);
    case URL_INFO_FILE_SHA1_HASH:
      throw GenTLError(GC_ERR_NOT_AVAILABLE, "the XML has no hash");
    default:
      no_answer(command);
  }
}

// The queue of an event. It is used without the library's lock, so that others can go on while somebody waits.
std::shared_ptr<EventQueue> queue_of(void* event) {
  const std::lock_guard lock(library().mutex);
  require_initialized();
  return library().event(event);
}

// The standard wants each entry of a stack done in turn, and the number of those that were.
template <typename Each>
void stacked(PORT_REGISTER_STACK_ENTRY* entries, std::size_t* count, const Each& each) {
  require_pointer(entries);
  require_pointer(count);
  const std::size_t wanted = *count;
  for (*count = 0; *count < wanted; ++*count) {
    PORT_REGISTER_STACK_ENTRY& entry = entries[*count];
    std::size_t size = entry.Size;
    each(entry, &size);
  }
}

}  // namespace

// Functions with the linkage of C are the same in every namespace.
// NOLINTBEGIN(readability-identifier-naming): names of the standard

// The library, the system and the interface.

GC_API GCGetInfo(TL_INFO_CMD iInfoCmd, INFO_DATATYPE* piType, void* pBuffer, std::size_t* piSize) {
  return guarded([&] { give_producer_info(iInfoCmd, {piType, pBuffer, piSize}); });
}

// Errors of this function do not replace the error that it reports.
GC_API GCGetLastError(GC_ERROR* piErrorCode, char* sErrorText, std::size_t* piSize) {
  if (piErrorCode == nullptr || piSize == nullptr) {
    return GC_ERR_INVALID_PARAMETER;
  }
  *piErrorCode = last_error().code;
  const char* const text = last_error().text.data();
  const std::size_t bytes = std::strlen(text) + 1;
  if (sErrorText != nullptr) {
    if (*piSize < bytes) {
      return GC_ERR_BUFFER_TOO_SMALL;
    }
    std::memcpy(sErrorText, text, bytes);
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
    close_module(library().system);
    library().initialized = false;
  });
}

GC_API TLOpen(TL_HANDLE* phSystem) {
  return call([&] {
    require_pointer(phSystem);
    require(library().system == nullptr, GC_ERR_RESOURCE_IN_USE, "the system is open already");
    library().system = make_module<System>();
    *phSystem = library().system->handle;
  });
}

GC_API TLClose(TL_HANDLE hSystem) {
  return on<System>(hSystem, [&](const System& /*module*/) { close_module(library().system); });
}

GC_API TLGetInfo(TL_HANDLE hSystem, TL_INFO_CMD iInfoCmd, INFO_DATATYPE* piType, void* pBuffer, std::size_t* piSize) {
  return on<System>(hSystem, [&](const System& /*module*/) {
    give_producer_info(iInfoCmd, {piType, pBuffer, piSize});
  });
}

GC_API TLGetNumInterfaces(TL_HANDLE hSystem, std::uint32_t* piNumIfaces) {
  return one_value<System>(hSystem, piNumIfaces, [](const System& /*module*/) { return 1U; });
}

GC_API TLGetInterfaceID(TL_HANDLE hSystem, std::uint32_t iIndex, char* sID, std::size_t* piSize) {
  return on<System>(hSystem, [&](const System& /*module*/) {
    require(iIndex == 0, GC_ERR_INVALID_INDEX, "there is one interface");
    give(kInterfaceId, {nullptr, sID, piSize});
  });
}

GC_API TLGetInterfaceInfo(TL_HANDLE hSystem, const char* sIfaceID, INTERFACE_INFO_CMD iInfoCmd, INFO_DATATYPE* piType,
                          void* pBuffer, std::size_t* piSize) {
  return on<System>(hSystem, [&](const System& /*module*/) {
    require_pointer(sIfaceID);
    require(std::strcmp(sIfaceID, kInterfaceId) == 0, GC_ERR_INVALID_ID, "there is no such interface");
    give_interface_info(iInfoCmd, {piType, pBuffer, piSize});
  });
}

GC_API TLOpenInterface(TL_HANDLE hSystem, const char* sIfaceID, IF_HANDLE* phIface) {
  return one_value<System>(hSystem, phIface, [&](System& system) { return system.open(sIfaceID)->handle; });
}

GC_API TLUpdateInterfaceList(TL_HANDLE hSystem, bool8_t* pbChanged, std::uint64_t /*iTimeout*/) {
  return on<System>(hSystem, [&](const System& /*module*/) {
    if (pbChanged != nullptr) {
      *pbChanged = 0;
    }
  });
}

GC_API IFClose(IF_HANDLE hIface) {
  return on<Interface>(hIface, [&](const Interface& /*module*/) { library().system->close_interface(); });
}

GC_API IFGetInfo(IF_HANDLE hIface, INTERFACE_INFO_CMD iInfoCmd, INFO_DATATYPE* piType, void* pBuffer,
                 std::size_t* piSize) {
  return on<Interface>(hIface, [&](const Interface& /*module*/) {
    give_interface_info(iInfoCmd, {piType, pBuffer, piSize});
  });
}

GC_API IFGetParentTL(IF_HANDLE hIface, TL_HANDLE* phSystem) {
  return one_value<Interface>(hIface, phSystem, [&](Interface& interface) { return interface.parent(); });
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
  return one_value<Interface>(hIface, piNumDevices, [&](Interface& interface) {
    return static_cast<std::uint32_t>(interface.devices().size());
  });
}

GC_API IFGetDeviceID(IF_HANDLE hIface, std::uint32_t iIndex, char* sIDeviceID, std::size_t* piSize) {
  return on<Interface>(hIface, [&](Interface& interface) {
    require(iIndex < interface.devices().size(), GC_ERR_INVALID_INDEX, "there are fewer devices");
    give(interface.devices()[iIndex].id, {nullptr, sIDeviceID, piSize});
  });
}

GC_API IFGetDeviceInfo(IF_HANDLE hIface, const char* sDeviceID, DEVICE_INFO_CMD iInfoCmd, INFO_DATATYPE* piType,
                       void* pBuffer, std::size_t* piSize) {
  return on<Interface>(hIface, [&](Interface& interface) {
    const DeviceEntry& entry = interface.entry(sDeviceID);
    give_device_info(entry, interface.opened(entry.id).get(), iInfoCmd, {piType, pBuffer, piSize});
  });
}

GC_API IFOpenDevice(IF_HANDLE hIface, const char* sDeviceID, DEVICE_ACCESS_FLAGS iOpenFlags, DEV_HANDLE* phDevice) {
  return one_value<Interface>(hIface, phDevice,
                              [&](Interface& interface) { return interface.open(sDeviceID, iOpenFlags)->handle; });
}

// Devices and data streams.

GC_API DevGetPort(DEV_HANDLE hDevice, PORT_HANDLE* phRemoteDevice) {
  return one_value<LocalDevice>(hDevice, phRemoteDevice, [&](LocalDevice& device) { return device.camera()->handle; });
}

GC_API DevGetNumDataStreams(DEV_HANDLE hDevice, std::uint32_t* piNumDataStreams) {
  return one_value<LocalDevice>(hDevice, piNumDataStreams, [](const LocalDevice& /*module*/) { return 1U; });
}

GC_API DevGetDataStreamID(DEV_HANDLE hDevice, std::uint32_t iIndex, char* sDataStreamID, std::size_t* piSize) {
  return on<LocalDevice>(hDevice, [&](const LocalDevice& /*module*/) {
    require(iIndex == 0, GC_ERR_INVALID_INDEX, "the device has one data stream");
    give(kStreamId, {nullptr, sDataStreamID, piSize});
  });
}

GC_API DevOpenDataStream(DEV_HANDLE hDevice, const char* sDataStreamID, DS_HANDLE* phDataStream) {
  return on<LocalDevice>(hDevice, [&](LocalDevice& device) {
    require_pointer(sDataStreamID);
    require_pointer(phDataStream);
    *phDataStream = device.open_stream(sDataStreamID)->handle;
  });
}

GC_API DevGetInfo(DEV_HANDLE hDevice, DEVICE_INFO_CMD iInfoCmd, INFO_DATATYPE* piType, void* pBuffer,
                  std::size_t* piSize) {
  return on<LocalDevice>(hDevice, [&](LocalDevice& device) {
    give_device_info(device.entry(), &device, iInfoCmd, {piType, pBuffer, piSize});
  });
}

GC_API DevClose(DEV_HANDLE hDevice) {
  return on<LocalDevice>(hDevice,
                         [](const LocalDevice& device) { library().system->interface()->close_device(device.id()); });
}

GC_API DevGetParentIF(DEV_HANDLE hDevice, IF_HANDLE* phIface) {
  return one_value<LocalDevice>(hDevice, phIface, [&](LocalDevice& device) { return device.parent(); });
}

GC_API DSGetParentDev(DS_HANDLE hDataStream, DEV_HANDLE* phDevice) {
  return one_value<Stream>(hDataStream, phDevice, [&](Stream& stream) { return stream.parent(); });
}

GC_API DSAnnounceBuffer(DS_HANDLE hDataStream, void* pBuffer, std::size_t iSize, void* pPrivate,
                        BUFFER_HANDLE* phBuffer) {
  return on<Stream>(hDataStream, [&](Stream& stream) {
    require_pointer(pBuffer);
    require_pointer(phBuffer);
    *phBuffer = stream.announce(pBuffer, iSize, pPrivate)->handle;
  });
}

GC_API DSAllocAndAnnounceBuffer(DS_HANDLE hDataStream, std::size_t iSize, void* pPrivate, BUFFER_HANDLE* phBuffer) {
  return one_value<Stream>(hDataStream, phBuffer,
                           [&](Stream& stream) { return stream.announce(nullptr, iSize, pPrivate)->handle; });
}

GC_API DSFlushQueue(DS_HANDLE hDataStream, ACQ_QUEUE_TYPE iOperation) {
  return call([&] { find<Stream>(hDataStream)->flush(iOperation); });
}

GC_API DSStartAcquisition(DS_HANDLE hDataStream, ACQ_START_FLAGS iStartFlags, std::uint64_t iNumToAcquire) {
  return on<Stream>(hDataStream, [&](Stream& stream) {
    require(iStartFlags == ACQ_START_FLAGS_DEFAULT, GC_ERR_INVALID_PARAMETER, "unknown flags of the start");
    stream.start(iNumToAcquire);
  });
}

GC_API DSStopAcquisition(DS_HANDLE hDataStream, ACQ_STOP_FLAGS iStopFlags) {
  return on<Stream>(hDataStream, [&](Stream& stream) {
    require(iStopFlags == ACQ_STOP_FLAGS_DEFAULT || iStopFlags == ACQ_STOP_FLAGS_KILL, GC_ERR_INVALID_PARAMETER,
            "unknown flags of the stop");
    require(stream.is_acquiring(), GC_ERR_RESOURCE_IN_USE, "the stream is not acquiring");
    stream.stop(iStopFlags);
  });
}

GC_API DSGetInfo(DS_HANDLE hDataStream, STREAM_INFO_CMD iInfoCmd, INFO_DATATYPE* piType, void* pBuffer,
                 std::size_t* piSize) {
  return call([&] { find<Stream>(hDataStream)->give_info(iInfoCmd, {piType, pBuffer, piSize}); });
}

GC_API DSGetBufferID(DS_HANDLE hDataStream, std::uint32_t iIndex, BUFFER_HANDLE* phBuffer) {
  return one_value<Stream>(hDataStream, phBuffer, [&](Stream& stream) { return stream.buffer_at(iIndex)->handle; });
}

GC_API DSClose(DS_HANDLE hDataStream) {
  return call([&] { find<LocalDevice>(find<Stream>(hDataStream)->parent())->close_stream(); });
}

GC_API DSRevokeBuffer(DS_HANDLE hDataStream, BUFFER_HANDLE hBuffer, void** pBuffer, void** pPrivate) {
  return on<Stream>(hDataStream, [&](Stream& stream) {
    const auto buffer = find<Buffer>(hBuffer);
    stream.revoke(buffer);
    if (pBuffer != nullptr) {
      *pBuffer = buffer->is_own() ? nullptr : buffer->memory();
    }
    if (pPrivate != nullptr) {
      *pPrivate = buffer->user();
    }
  });
}

GC_API DSQueueBuffer(DS_HANDLE hDataStream, BUFFER_HANDLE hBuffer) {
  return on<Stream>(hDataStream, [&](Stream& stream) { stream.queue(find<Buffer>(hBuffer)); });
}

GC_API DSGetBufferInfo(DS_HANDLE hDataStream, BUFFER_HANDLE hBuffer, BUFFER_INFO_CMD iInfoCmd, INFO_DATATYPE* piType,
                       void* pBuffer, std::size_t* piSize) {
  return on_buffer(hDataStream, hBuffer, [&](const Buffer& buffer, const BufferContents& contents) {
    give_buffer_info(buffer, contents, iInfoCmd, {piType, pBuffer, piSize});
  });
}

GC_API DSGetBufferChunkData(DS_HANDLE hDataStream, BUFFER_HANDLE hBuffer, SINGLE_CHUNK_DATA* pChunkData,
                            std::size_t* piNumChunks) {
  return on_buffer(hDataStream, hBuffer, [&](const Buffer& /*buffer*/, const BufferContents& contents) {
    require_pointer(piNumChunks);
    require(contents.lines > 0, GC_ERR_NO_DATA, "the buffer has no data yet");
    const std::vector<SINGLE_CHUNK_DATA> places = contents.layout.chunk_places(contents.lines);
    if (pChunkData != nullptr) {
      require(*piNumChunks >= places.size(), GC_ERR_BUFFER_TOO_SMALL, "there are more chunks");
      std::copy(places.begin(), places.end(), pChunkData);
    }
    *piNumChunks = places.size();
  });
}

GC_API DSGetNumBufferParts(DS_HANDLE hDataStream, BUFFER_HANDLE hBuffer, std::uint32_t* piNumParts) {
  return on_buffer(hDataStream, hBuffer, [&](const Buffer& /*buffer*/, const BufferContents& contents) {
    require_pointer(piNumParts);
    require(contents.lines > 0, GC_ERR_NO_DATA, "the buffer has no data yet");
    const std::size_t parts = contents.layout.parts().size();
    *piNumParts = parts > 1 ? static_cast<std::uint32_t>(parts) : 0;  // 0: the buffer is not of parts
  });
}

GC_API DSGetBufferPartInfo(DS_HANDLE hDataStream, BUFFER_HANDLE hBuffer, std::uint32_t iPartIndex,
                           BUFFER_PART_INFO_CMD iInfoCmd, INFO_DATATYPE* piType, void* pBuffer, std::size_t* piSize) {
  return on_buffer(hDataStream, hBuffer, [&](const Buffer& buffer, const BufferContents& contents) {
    give_part_info(buffer, contents, iPartIndex, iInfoCmd, {piType, pBuffer, piSize});
  });
}

// Ports and events.

GC_API GCReadPort(PORT_HANDLE hPort, std::uint64_t iAddress, void* pBuffer, std::size_t* piSize) {
  return call([&] { read_port(hPort, iAddress, pBuffer, piSize); });
}

GC_API GCWritePort(PORT_HANDLE hPort, std::uint64_t iAddress, const void* pBuffer, std::size_t* piSize) {
  return call([&] { write_port(hPort, iAddress, pBuffer, piSize); });
}

GC_API GCReadPortStacked(PORT_HANDLE hPort, PORT_REGISTER_STACK_ENTRY* pEntries, std::size_t* piNumEntries) {
  return call([&] {
    stacked(pEntries, piNumEntries, [&](const PORT_REGISTER_STACK_ENTRY& entry, std::size_t* size) {
      read_port(hPort, entry.Address, entry.pBuffer, size);
    });
  });
}

GC_API GCWritePortStacked(PORT_HANDLE hPort, PORT_REGISTER_STACK_ENTRY* pEntries, std::size_t* piNumEntries) {
  return call([&] {
    stacked(pEntries, piNumEntries, [&](const PORT_REGISTER_STACK_ENTRY& entry, std::size_t* size) {
      write_port(hPort, entry.Address, entry.pBuffer, size);
    });
  });
}

GC_API GCGetPortURL(PORT_HANDLE hPort, char* sURL, std::size_t* piSize) {
  return call([&] { give(library().module(hPort)->features().url(), {nullptr, sURL, piSize}); });
}

GC_API GCGetNumPortURLs(PORT_HANDLE hPort, std::uint32_t* piNumURLs) {
  return call([&] {
    static_cast<void>(library().module(hPort));
    require_pointer(piNumURLs);
    *piNumURLs = 1;
  });
}

GC_API GCGetPortURLInfo(PORT_HANDLE hPort, std::uint32_t iURLIndex, URL_INFO_CMD iInfoCmd, INFO_DATATYPE* piType,
                        void* pBuffer, std::size_t* piSize) {
  return call([&] {
    const auto module = library().module(hPort);
    require(iURLIndex == 0, GC_ERR_INVALID_INDEX, "there is one URL");
    give_url_info(*module, iInfoCmd, {piType, pBuffer, piSize});
  });
}

GC_API GCGetPortInfo(PORT_HANDLE hPort, PORT_INFO_CMD iInfoCmd, INFO_DATATYPE* piType, void* pBuffer,
                     std::size_t* piSize) {
  return call([&] { give_port_info(*library().module(hPort), iInfoCmd, {piType, pBuffer, piSize}); });
}

GC_API GCRegisterEvent(EVENTSRC_HANDLE hEventSrc, EVENT_TYPE iEventID, EVENT_HANDLE* phEvent) {
  return call([&] {
    const auto module = library().module(hEventSrc);
    require_pointer(phEvent);
    *phEvent = module->register_event(iEventID);
  });
}

GC_API GCUnregisterEvent(EVENTSRC_HANDLE hEventSrc, EVENT_TYPE iEventID) {
  return call([&] { library().module(hEventSrc)->unregister_event(iEventID); });
}

GC_API EventGetData(EVENT_HANDLE hEvent, void* pBuffer, std::size_t* piSize, std::uint64_t iTimeout) {
  return guarded([&] { queue_of(hEvent)->get(pBuffer, piSize, iTimeout); });
}

GC_API EventGetDataInfo(EVENT_HANDLE hEvent, const void* pInBuffer, std::size_t iInSize, EVENT_DATA_INFO_CMD iInfoCmd,
                        INFO_DATATYPE* piType, void* pOutBuffer, std::size_t* piOutSize) {
  return guarded([&] {
    const auto queue = queue_of(hEvent);
    require_pointer(pInBuffer);
    require(iInSize >= queue->event_bytes(), GC_ERR_INVALID_PARAMETER, "the data are shorter than those of an event");
    require(iInfoCmd == EVENT_DATA_ID || iInfoCmd == EVENT_DATA_VALUE, GC_ERR_NOT_IMPLEMENTED,
            "events have an ID and a value");
    const Answer to{piType, pOutBuffer, piOutSize};
    if (queue->type() == EVENT_NEW_BUFFER) {
      EVENT_NEW_BUFFER_DATA data{};
      std::memcpy(&data, pInBuffer, sizeof data);
      return give(iInfoCmd == EVENT_DATA_ID ? data.BufferHandle : data.pUserPointer, to);
    }
    ErrorEventData data;
    std::memcpy(&data, pInBuffer, sizeof data);
    data.text[sizeof data.text - 1] = '\0';
    return iInfoCmd == EVENT_DATA_ID ? give(data.code, to) : give(data.text, to);
  });
}

GC_API EventGetInfo(EVENT_HANDLE hEvent, EVENT_INFO_CMD iInfoCmd, INFO_DATATYPE* piType, void* pBuffer,
                    std::size_t* piSize) {
  return guarded([&] {
    const auto queue = queue_of(hEvent);
    const Answer to{piType, pBuffer, piSize};
    switch (iInfoCmd) {
      case EVENT_EVENT_TYPE:
        return give(queue->type(), to);
      case EVENT_NUM_IN_QUEUE:
        return give_size(queue->size(), to);
      case EVENT_NUM_FIRED:
        return give(queue->fired(), to);
      case EVENT_SIZE_MAX:
        return give_size(queue->event_bytes(), to);
      case EVENT_INFO_DATA_SIZE_MAX:
        return give_size(queue->type() == EVENT_NEW_BUFFER ? sizeof(void*) : sizeof(ErrorEventData::text), to);
      default:
        no_answer(iInfoCmd);
    }
  });
}

GC_API EventFlush(EVENT_HANDLE hEvent) {
  return guarded([&] { queue_of(hEvent)->flush(); });
}

GC_API EventKill(EVENT_HANDLE hEvent) {
  return guarded([&] { queue_of(hEvent)->kill(); });
}

// NOLINTEND(readability-identifier-naming)

}  // namespace selfproj::gentl
