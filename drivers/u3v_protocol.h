// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// What a U3V compatible camera and its host say to each other, as pure functions from bytes to values and back. All
// integers are little-endian.
namespace geond::drivers::u3v {

using Bytes = std::vector<std::uint8_t>;
using ByteView = std::span<const std::uint8_t>;

inline constexpr std::uint32_t kControlMagic = 0x43563355;  // "U3VC"
inline constexpr std::uint32_t kLeaderMagic = 0x4C563355;   // "U3VL"
inline constexpr std::uint32_t kTrailerMagic = 0x54563355;  // "U3VT"
inline constexpr std::size_t kControlHeaderSize = 12;
inline constexpr std::size_t kReadMemSize = kControlHeaderSize + 12;

enum class Command : std::uint16_t { kReadMem = 0x0800, kWriteMem = 0x0802 };
inline constexpr std::uint16_t kPendingAck = 0x0805;

// A command as it goes out, acknowledge wanted. Request ids run from 1 to 0xffff.
Bytes EncodeReadMem(std::uint16_t request_id, std::uint64_t address, std::uint16_t count);
Bytes EncodeWriteMem(std::uint16_t request_id, std::uint64_t address, ByteView data);

// What an incoming control packet is, seen from the request that waits for it.
struct Ack {
  enum class Kind {
    kAnswer,   // to this request: `data` (ReadMem) or `written` (WriteMem)
    kPending,  // the device is still at work: wait `pending_ms` more
    kStale,    // the answer to another request: read again
    kRefused,  // `status` says why
    kBroken,   // not a well-formed acknowledge: `error` names the rule
  };
  Kind kind = Kind::kBroken;
  Bytes data;
  std::uint16_t written = 0;
  std::uint16_t pending_ms = 0;
  std::uint16_t status = 0;
  std::string error;
};
Ack DecodeAck(ByteView packet, Command command, std::uint16_t request_id, std::size_t expected_count);

// A status code of a control acknowledge or a trailer, in words.
std::string_view StatusWords(std::uint16_t status);

// Payload types of the leader that carry an image.
inline constexpr std::uint16_t kImagePayload = 0x0001;
inline constexpr std::uint16_t kImageWithChunksPayload = 0x4001;

struct Leader {
  std::uint64_t block_id = 0;
  std::uint16_t payload_type = 0;
  std::uint64_t timestamp_ns = 0;
  std::uint32_t pixel_format = 0;
  std::uint32_t width = 0, height = 0;
  std::uint32_t offset_x = 0, offset_y = 0;
  std::uint16_t padding_x = 0;  // bytes at the end of each row
};

struct Trailer {
  std::uint64_t block_id = 0;
  std::uint16_t status = 0;
  std::uint64_t valid_payload_size = 0;
  std::uint32_t height = 0;  // rows really sent
};

// Empty, with the broken rule in `error`, if the packet is none.
std::optional<Leader> DecodeLeader(ByteView packet, std::string& error);
std::optional<Trailer> DecodeTrailer(ByteView packet, std::string& error);
Bytes EncodeLeader(const Leader& leader);
Bytes EncodeTrailer(const Trailer& trailer);

// Pixel formats a range camera sends (GenICam PFNC codes).
enum class PixelFormat : std::uint32_t {
  kCoord3dC16 = 0x011000B8,    // depth
  kCoord3dC32f = 0x012000BF,   // depth
  kCoord3dAbc16 = 0x023000B9,  // x, y, depth
  kCoord3dAbc32f = 0x026000C0,
};
// Bytes a pixel; 0 for a format that is none of the above.
std::size_t BytesPerPixel(std::uint32_t pixel_format);

// Why a received frame must not be used: the first rule of the transport that leader, trailer and the number of bytes
// received break; empty if none.
std::string FrameFault(const Leader& leader, const Trailer& trailer, std::uint64_t received);

}  // namespace geond::drivers::u3v
