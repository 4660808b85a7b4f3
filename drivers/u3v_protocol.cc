// SPDX-License-Identifier: Apache-2.0
#include "drivers/u3v_protocol.h"

#include "drivers/little_endian.h"

namespace geond::drivers::u3v {
namespace {

constexpr std::uint16_t kAcknowledgeWanted = 0x4000;
// Some devices leave the last two bytes of the leader, which mean nothing, out of its size.
constexpr std::size_t kLeaderSize = 52, kShortLeaderSize = 50, kTrailerSize = 32;

Bytes CommandHeader(Command command, std::uint16_t request_id, std::size_t payload_size) {
  Bytes packet;
  packet.reserve(kControlHeaderSize + payload_size);
  AppendLittleEndian(kControlMagic, packet);
  AppendLittleEndian(kAcknowledgeWanted, packet);
  AppendLittleEndian(static_cast<std::uint16_t>(command), packet);
  AppendLittleEndian(static_cast<std::uint16_t>(payload_size), packet);
  AppendLittleEndian(request_id, packet);
  return packet;
}

Ack Broken(std::string error) {
  Ack ack;
  ack.error = std::move(error);
  return ack;
}

std::string Sizes(std::size_t received, std::size_t expected) {
  return std::to_string(received) + " bytes where " + std::to_string(expected) + " were due";
}

}  // namespace

Bytes EncodeReadMem(std::uint16_t request_id, std::uint64_t address, std::uint16_t count) {
  Bytes packet = CommandHeader(Command::kReadMem, request_id, 12);
  AppendLittleEndian(address, packet);
  AppendLittleEndian(std::uint16_t{0}, packet);
  AppendLittleEndian(count, packet);
  return packet;
}

Bytes EncodeWriteMem(std::uint16_t request_id, std::uint64_t address, ByteView data) {
  Bytes packet = CommandHeader(Command::kWriteMem, request_id, 8 + data.size());
  AppendLittleEndian(address, packet);
  packet.insert(packet.end(), data.begin(), data.end());
  return packet;
}

Ack DecodeAck(ByteView packet, Command command, std::uint16_t request_id, std::size_t expected_count) {
  if (packet.size() < kControlHeaderSize) return Broken("acknowledge of " + Sizes(packet.size(), kControlHeaderSize));
  if (ReadLittleEndian<std::uint32_t>(packet, 0) != kControlMagic) return Broken("acknowledge without its magic number");
  const std::size_t length = ReadLittleEndian<std::uint16_t>(packet, 8);
  if (packet.size() != kControlHeaderSize + length) {
    return Broken("acknowledge of " + Sizes(packet.size(), kControlHeaderSize + length));
  }
  const ByteView payload = packet.subspan(kControlHeaderSize);
  Ack ack;
  if (ReadLittleEndian<std::uint16_t>(packet, 10) != request_id) {
    ack.kind = Ack::Kind::kStale;
    return ack;
  }
  const std::uint16_t answered = ReadLittleEndian<std::uint16_t>(packet, 6);
  ack.status = ReadLittleEndian<std::uint16_t>(packet, 4);
  if (answered == kPendingAck) {
    if (payload.size() != 4) return Broken("pending acknowledge of " + Sizes(payload.size(), 4));
    ack.kind = Ack::Kind::kPending;
    ack.pending_ms = ReadLittleEndian<std::uint16_t>(payload, 2);
    return ack;
  }
  if (answered != static_cast<std::uint16_t>(command) + 1) return Broken("acknowledge of another command");
  if (ack.status != 0) {
    ack.kind = Ack::Kind::kRefused;
    ack.error = StatusWords(ack.status);
    return ack;
  }
  if (command == Command::kReadMem) {
    if (payload.size() != expected_count) return Broken("register data of " + Sizes(payload.size(), expected_count));
    ack.data.assign(payload.begin(), payload.end());
  } else {
    // Some devices leave the count out.
    ack.written = payload.size() >= 4 ? ReadLittleEndian<std::uint16_t>(payload, 2)
                                      : static_cast<std::uint16_t>(expected_count);
    if (ack.written != expected_count) return Broken("write of " + Sizes(ack.written, expected_count));
  }
  ack.kind = Ack::Kind::kAnswer;
  return ack;
}

std::string_view StatusWords(std::uint16_t status) {
  switch (status) {
    case 0x0000: return "ok";
    case 0x8001: return "command not implemented";
    case 0x8002: return "invalid parameter";
    case 0x8003: return "invalid address";
    case 0x8004: return "register is write protected";
    case 0x8005: return "address badly aligned";
    case 0x8006: return "access denied";
    case 0x8007: return "device busy";
    case 0x800B: return "device timed out";
    case 0x800E: return "invalid header";
    case 0x800F: return "wrong configuration";
    case 0x8FFF: return "error without a name";
    case 0xA001: return "resend not supported";
    case 0xA002: return "stream endpoint halted";
    case 0xA003: return "payload size not aligned";
    case 0xA004: return "stream registers inconsistent";
    case 0xA005: return "event endpoint halted";
    case 0xA100: return "data discarded by the device";
    case 0xA101: return "data overrun in the device";
    default: return "unknown status";
  }
}

std::optional<Leader> DecodeLeader(ByteView packet, std::string& error) {
  if (packet.size() < kShortLeaderSize) {
    error = "leader of " + Sizes(packet.size(), kLeaderSize);
  } else if (ReadLittleEndian<std::uint32_t>(packet, 0) != kLeaderMagic) {
    error = "leader without its magic number";
  } else if (const std::size_t size = ReadLittleEndian<std::uint16_t>(packet, 6); size > packet.size() || size < kShortLeaderSize) {
    error = "leader that says it has " + std::to_string(size) + " bytes";
  } else {
    Leader leader;
    leader.block_id = ReadLittleEndian<std::uint64_t>(packet, 8);
    leader.payload_type = ReadLittleEndian<std::uint16_t>(packet, 18);
    leader.timestamp_ns = ReadLittleEndian<std::uint64_t>(packet, 20);
    leader.pixel_format = ReadLittleEndian<std::uint32_t>(packet, 28);
    leader.width = ReadLittleEndian<std::uint32_t>(packet, 32);
    leader.height = ReadLittleEndian<std::uint32_t>(packet, 36);
    leader.offset_x = ReadLittleEndian<std::uint32_t>(packet, 40);
    leader.offset_y = ReadLittleEndian<std::uint32_t>(packet, 44);
    leader.padding_x = ReadLittleEndian<std::uint16_t>(packet, 48);
    return leader;
  }
  return std::nullopt;
}

std::optional<Trailer> DecodeTrailer(ByteView packet, std::string& error) {
  if (packet.size() < kTrailerSize) {
    error = "trailer of " + Sizes(packet.size(), kTrailerSize);
  } else if (ReadLittleEndian<std::uint32_t>(packet, 0) != kTrailerMagic) {
    error = "trailer without its magic number";
  } else if (const std::size_t size = ReadLittleEndian<std::uint16_t>(packet, 6); size > packet.size() || size < kTrailerSize) {
    error = "trailer that says it has " + std::to_string(size) + " bytes";
  } else {
    Trailer trailer;
    trailer.block_id = ReadLittleEndian<std::uint64_t>(packet, 8);
    trailer.status = ReadLittleEndian<std::uint16_t>(packet, 16);
    trailer.valid_payload_size = ReadLittleEndian<std::uint64_t>(packet, 20);
    trailer.height = ReadLittleEndian<std::uint32_t>(packet, 28);
    return trailer;
  }
  return std::nullopt;
}

Bytes EncodeLeader(const Leader& leader) {
  Bytes packet;
  AppendLittleEndian(kLeaderMagic, packet);
  AppendLittleEndian(std::uint16_t{0}, packet);
  AppendLittleEndian(static_cast<std::uint16_t>(kLeaderSize), packet);
  AppendLittleEndian(leader.block_id, packet);
  AppendLittleEndian(std::uint16_t{0}, packet);
  AppendLittleEndian(leader.payload_type, packet);
  AppendLittleEndian(leader.timestamp_ns, packet);
  for (std::uint32_t value : {leader.pixel_format, leader.width, leader.height, leader.offset_x, leader.offset_y}) {
    AppendLittleEndian(value, packet);
  }
  AppendLittleEndian(leader.padding_x, packet);
  AppendLittleEndian(std::uint16_t{0}, packet);
  return packet;
}

Bytes EncodeTrailer(const Trailer& trailer) {
  Bytes packet;
  AppendLittleEndian(kTrailerMagic, packet);
  AppendLittleEndian(std::uint16_t{0}, packet);
  AppendLittleEndian(static_cast<std::uint16_t>(kTrailerSize), packet);
  AppendLittleEndian(trailer.block_id, packet);
  AppendLittleEndian(trailer.status, packet);
  AppendLittleEndian(std::uint16_t{0}, packet);
  AppendLittleEndian(trailer.valid_payload_size, packet);
  AppendLittleEndian(trailer.height, packet);
  return packet;
}

std::size_t BytesPerPixel(std::uint32_t pixel_format) {
  switch (static_cast<PixelFormat>(pixel_format)) {
    case PixelFormat::kCoord3dC16: return 2;
    case PixelFormat::kCoord3dC32f: return 4;
    case PixelFormat::kCoord3dAbc16: return 6;
    case PixelFormat::kCoord3dAbc32f: return 12;
  }
  return 0;
}

std::string FrameFault(const Leader& leader, const Trailer& trailer, std::uint64_t received) {
  if (leader.payload_type != kImagePayload && leader.payload_type != kImageWithChunksPayload) return "payload is no image";
  if (leader.block_id != trailer.block_id) {
    return "leader of block " + std::to_string(leader.block_id) + ", trailer of block " + std::to_string(trailer.block_id);
  }
  if (trailer.status != 0) return "trailer says: " + std::string(StatusWords(trailer.status));
  const std::size_t pixel = BytesPerPixel(leader.pixel_format);
  if (pixel == 0) return "pixel format " + std::to_string(leader.pixel_format) + " is none of range data";
  if (received != trailer.valid_payload_size) return "payload of " + Sizes(received, trailer.valid_payload_size);
  if (trailer.height > leader.height) return "more rows than the leader announced";
  if (leader.width == 0 || trailer.height == 0) return "an image without pixels";
  // By division: the product of what a broken leader says need not fit a number.
  const std::uint64_t row = std::uint64_t{leader.width} * pixel + leader.padding_x;
  const std::uint64_t rows = trailer.valid_payload_size / row;
  const bool chunks = leader.payload_type == kImageWithChunksPayload;
  if (chunks ? rows < trailer.height : rows != trailer.height || trailer.valid_payload_size % row != 0) {
    return "payload of " + std::to_string(trailer.valid_payload_size) + " bytes for an image of " +
           std::to_string(trailer.height) + " rows of " + std::to_string(row);
  }
  return {};
}

}  // namespace geond::drivers::u3v
