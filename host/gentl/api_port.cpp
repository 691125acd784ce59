// The functions of ports and events.
#include <cstring>
#include <memory>
#include <span>
#include <string>

#include "host/gentl/answer.h"
#include "host/gentl/event_queue.h"
#include "host/gentl/gentl_errors.h"
#include "host/gentl/gentl_types.h"
#include "host/gentl/library.h"
#include "host/gentl/module.h"
#include "host/gentl/system.h"

// Functions with the linkage of C are the same in every namespace.
namespace selfproj::gentl {

namespace {

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

// NOLINTBEGIN(readability-identifier-naming): names of the standard

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
