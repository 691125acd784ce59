// The functions of devices and data streams.
#include <algorithm>
#include <memory>
#include <vector>

#include "host/gentl/answer.h"
#include "host/gentl/gentl_errors.h"
#include "host/gentl/gentl_types.h"
#include "host/gentl/library.h"
#include "host/gentl/stream.h"
#include "host/gentl/system.h"

// Functions with the linkage of C are the same in every namespace.
namespace selfproj::gentl {

// NOLINTBEGIN(readability-identifier-naming): names of the standard

GC_API DevGetPort(DEV_HANDLE hDevice, PORT_HANDLE* phRemoteDevice) {
  return call([&] {
    const auto device = find<LocalDevice>(hDevice);
    require_pointer(phRemoteDevice);
    *phRemoteDevice = device->camera()->handle;
  });
}

GC_API DevGetNumDataStreams(DEV_HANDLE hDevice, std::uint32_t* piNumDataStreams) {
  return call([&] {
    find<LocalDevice>(hDevice);
    require_pointer(piNumDataStreams);
    *piNumDataStreams = 1;
  });
}

GC_API DevGetDataStreamID(DEV_HANDLE hDevice, std::uint32_t iIndex, char* sDataStreamID, std::size_t* piSize) {
  return call([&] {
    find<LocalDevice>(hDevice);
    require(iIndex == 0, GC_ERR_INVALID_INDEX, "the device has one data stream");
    give(kStreamId, {nullptr, sDataStreamID, piSize});
  });
}

GC_API DevOpenDataStream(DEV_HANDLE hDevice, const char* sDataStreamID, DS_HANDLE* phDataStream) {
  return call([&] {
    const auto device = find<LocalDevice>(hDevice);
    require_pointer(sDataStreamID);
    require_pointer(phDataStream);
    *phDataStream = device->open_stream(sDataStreamID)->handle;
  });
}

GC_API DevGetInfo(DEV_HANDLE hDevice, DEVICE_INFO_CMD iInfoCmd, INFO_DATATYPE* piType, void* pBuffer,
                  std::size_t* piSize) {
  return call([&] {
    const auto device = find<LocalDevice>(hDevice);
    give_device_info(device->entry(), device.get(), iInfoCmd, {piType, pBuffer, piSize});
  });
}

GC_API DevClose(DEV_HANDLE hDevice) {
  return call([&] {
    const auto device = find<LocalDevice>(hDevice);
    library().system->interface()->close_device(device);
  });
}

GC_API DevGetParentIF(DEV_HANDLE hDevice, IF_HANDLE* phIface) {
  return call([&] {
    const auto device = find<LocalDevice>(hDevice);
    require_pointer(phIface);
    *phIface = device->parent();
  });
}

GC_API DSGetParentDev(DS_HANDLE hDataStream, DEV_HANDLE* phDevice) {
  return call([&] {
    const auto stream = find<Stream>(hDataStream);
    require_pointer(phDevice);
    *phDevice = stream->parent();
  });
}

GC_API DSAnnounceBuffer(DS_HANDLE hDataStream, void* pBuffer, std::size_t iSize, void* pPrivate,
                        BUFFER_HANDLE* phBuffer) {
  return call([&] {
    const auto stream = find<Stream>(hDataStream);
    require_pointer(pBuffer);
    require_pointer(phBuffer);
    *phBuffer = stream->announce(pBuffer, iSize, pPrivate)->handle;
  });
}

GC_API DSAllocAndAnnounceBuffer(DS_HANDLE hDataStream, std::size_t iSize, void* pPrivate, BUFFER_HANDLE* phBuffer) {
  return call([&] {
    const auto stream = find<Stream>(hDataStream);
    require_pointer(phBuffer);
    *phBuffer = stream->announce(nullptr, iSize, pPrivate)->handle;
  });
}

GC_API DSFlushQueue(DS_HANDLE hDataStream, ACQ_QUEUE_TYPE iOperation) {
  return call([&] { find<Stream>(hDataStream)->flush(iOperation); });
}

GC_API DSStartAcquisition(DS_HANDLE hDataStream, ACQ_START_FLAGS iStartFlags, std::uint64_t iNumToAcquire) {
  return call([&] {
    const auto stream = find<Stream>(hDataStream);
    require(iStartFlags == ACQ_START_FLAGS_DEFAULT, GC_ERR_INVALID_PARAMETER, "unknown flags of the start");
    stream->start(iNumToAcquire);
  });
}

GC_API DSStopAcquisition(DS_HANDLE hDataStream, ACQ_STOP_FLAGS iStopFlags) {
  return call([&] {
    const auto stream = find<Stream>(hDataStream);
    require(iStopFlags == ACQ_STOP_FLAGS_DEFAULT || iStopFlags == ACQ_STOP_FLAGS_KILL, GC_ERR_INVALID_PARAMETER,
            "unknown flags of the stop");
    require(stream->is_acquiring(), GC_ERR_RESOURCE_IN_USE, "the stream is not acquiring");
    stream->stop(iStopFlags);
  });
}

GC_API DSGetInfo(DS_HANDLE hDataStream, STREAM_INFO_CMD iInfoCmd, INFO_DATATYPE* piType, void* pBuffer,
                 std::size_t* piSize) {
  return call([&] { find<Stream>(hDataStream)->give_info(iInfoCmd, {piType, pBuffer, piSize}); });
}

GC_API DSGetBufferID(DS_HANDLE hDataStream, std::uint32_t iIndex, BUFFER_HANDLE* phBuffer) {
  return call([&] {
    const auto stream = find<Stream>(hDataStream);
    require_pointer(phBuffer);
    *phBuffer = stream->buffer_at(iIndex)->handle;
  });
}

GC_API DSClose(DS_HANDLE hDataStream) {
  return call([&] { find<LocalDevice>(find<Stream>(hDataStream)->parent())->close_stream(); });
}

GC_API DSRevokeBuffer(DS_HANDLE hDataStream, BUFFER_HANDLE hBuffer, void** pBuffer, void** pPrivate) {
  return call([&] {
    const auto stream = find<Stream>(hDataStream);
    const auto buffer = find<Buffer>(hBuffer);
    stream->revoke(buffer);
    if (pBuffer != nullptr) {
      *pBuffer = buffer->is_own() ? nullptr : buffer->memory();
    }
    if (pPrivate != nullptr) {
      *pPrivate = buffer->user();
    }
  });
}

GC_API DSQueueBuffer(DS_HANDLE hDataStream, BUFFER_HANDLE hBuffer) {
  return call([&] {
    const auto stream = find<Stream>(hDataStream);
    stream->queue(find<Buffer>(hBuffer));
  });
}

GC_API DSGetBufferInfo(DS_HANDLE hDataStream, BUFFER_HANDLE hBuffer, BUFFER_INFO_CMD iInfoCmd, INFO_DATATYPE* piType,
                       void* pBuffer, std::size_t* piSize) {
  return call([&] {
    const auto stream = find<Stream>(hDataStream);
    const auto buffer = find<Buffer>(hBuffer);
    stream->require_own(buffer);
    give_buffer_info(*buffer, stream->contents_of(*buffer), iInfoCmd, {piType, pBuffer, piSize});
  });
}

GC_API DSGetBufferChunkData(DS_HANDLE hDataStream, BUFFER_HANDLE hBuffer, SINGLE_CHUNK_DATA* pChunkData,
                            std::size_t* piNumChunks) {
  return call([&] {
    const auto stream = find<Stream>(hDataStream);
    const auto buffer = find<Buffer>(hBuffer);
    stream->require_own(buffer);
    require_pointer(piNumChunks);
    const BufferContents contents = stream->contents_of(*buffer);
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
  return call([&] {
    const auto stream = find<Stream>(hDataStream);
    const auto buffer = find<Buffer>(hBuffer);
    stream->require_own(buffer);
    require_pointer(piNumParts);
    const BufferContents contents = stream->contents_of(*buffer);
    require(contents.lines > 0, GC_ERR_NO_DATA, "the buffer has no data yet");
    const std::size_t parts = contents.layout.parts().size();
    *piNumParts = parts > 1 ? static_cast<std::uint32_t>(parts) : 0;  // 0: the buffer is not of parts
  });
}

GC_API DSGetBufferPartInfo(DS_HANDLE hDataStream, BUFFER_HANDLE hBuffer, std::uint32_t iPartIndex,
                           BUFFER_PART_INFO_CMD iInfoCmd, INFO_DATATYPE* piType, void* pBuffer, std::size_t* piSize) {
  return call([&] {
    const auto stream = find<Stream>(hDataStream);
    const auto buffer = find<Buffer>(hBuffer);
    stream->require_own(buffer);
    give_part_info(*buffer, stream->contents_of(*buffer), iPartIndex, iInfoCmd, {piType, pBuffer, piSize});
  });
}

// NOLINTEND(readability-identifier-naming)

}  // namespace selfproj::gentl
