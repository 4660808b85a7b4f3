// SPDX-License-Identifier: Apache-2.0
#include "drivers/u3v_protocol.h"

#include <bit>
#include <cmath>
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>

#include "drivers/little_endian.h"
#include "drivers/u3v_depth.h"

namespace geond::drivers::u3v {
namespace {

Bytes ReadVector(const std::string& name) {
  std::ifstream file(std::string(GEOND_TEST_DATA) + "/u3v/" + name, std::ios::binary);
  EXPECT_TRUE(file) << name;
  return {std::istreambuf_iterator<char>(file), {}};
}

Bytes AckPacket(std::uint16_t status, std::uint16_t command, std::uint16_t id, const Bytes& payload) {
  Bytes packet;
  AppendLittleEndian(kControlMagic, packet);
  AppendLittleEndian(status, packet);
  AppendLittleEndian(command, packet);
  AppendLittleEndian(static_cast<std::uint16_t>(payload.size()), packet);
  AppendLittleEndian(id, packet);
  packet.insert(packet.end(), payload.begin(), payload.end());
  return packet;
}

Leader SomeLeader() {
  Leader leader;
  leader.block_id = 7;
  leader.payload_type = kImagePayload;
  leader.timestamp_ns = 123456789;
  leader.pixel_format = static_cast<std::uint32_t>(PixelFormat::kCoord3dC16);
  leader.width = 4;
  leader.height = 3;
  return leader;
}

Trailer MatchingTrailer(const Leader& leader) {
  Trailer trailer;
  trailer.block_id = leader.block_id;
  trailer.height = leader.height;
  trailer.valid_payload_size = (leader.width * BytesPerPixel(leader.pixel_format) + leader.padding_x) * leader.height;
  return trailer;
}

TEST(EncodeReadMem, IsWhatALibraryInTheFieldSends) {
  // Captured: Aravis 0.8.26 reads 64 bytes at address 4 with request id 0xff15.
  const Bytes captured{0x55, 0x33, 0x56, 0x43, 0x00, 0x40, 0x00, 0x08, 0x0c, 0x00, 0x15, 0xff,
                       0x04, 0,    0,    0,    0,    0,    0,    0,    0,    0,    0x40, 0};
  EXPECT_EQ(EncodeReadMem(0xff15, 4, 64), captured);
  EXPECT_EQ(EncodeReadMem(1, 0, 4).size(), kReadMemSize);
}

TEST(EncodeWriteMem, CarriesAddressAndData) {
  const Bytes packet = EncodeWriteMem(9, 0x1122334455667788, Bytes{1, 2, 3, 4});
  EXPECT_EQ(ReadLittleEndian<std::uint16_t>(packet, 8), 12);
  EXPECT_EQ(ReadLittleEndian<std::uint64_t>(packet, 12), 0x1122334455667788u);
  EXPECT_EQ(Bytes(packet.begin() + 20, packet.end()), (Bytes{1, 2, 3, 4}));
}

TEST(DecodeAck, GivesTheDataOfTheAnswer) {
  const Ack ack = DecodeAck(AckPacket(0, 0x0801, 5, {1, 2, 3, 4}), Command::kReadMem, 5, 4);
  EXPECT_EQ(ack.kind, Ack::Kind::kAnswer);
  EXPECT_EQ(ack.data, (Bytes{1, 2, 3, 4}));
  EXPECT_EQ(DecodeAck(AckPacket(0, 0x0803, 5, {0, 0, 8, 0}), Command::kWriteMem, 5, 8).written, 8);
}

TEST(DecodeAck, TellsPendingStaleRefusedAndBrokenApart) {
  const Ack pending = DecodeAck(AckPacket(0, kPendingAck, 5, {0, 0, 0x2c, 0x01}), Command::kReadMem, 5, 4);
  EXPECT_EQ(pending.kind, Ack::Kind::kPending);
  EXPECT_EQ(pending.pending_ms, 300);
  EXPECT_EQ(DecodeAck(AckPacket(0, 0x0801, 4, {1, 2, 3, 4}), Command::kReadMem, 5, 4).kind, Ack::Kind::kStale);
  const Ack refused = DecodeAck(AckPacket(0x8003, 0x0801, 5, {}), Command::kReadMem, 5, 4);
  EXPECT_EQ(refused.kind, Ack::Kind::kRefused);
  EXPECT_EQ(refused.error, "invalid address");
  EXPECT_EQ(DecodeAck(AckPacket(0, 0x0803, 5, {1, 2, 3, 4}), Command::kReadMem, 5, 4).kind, Ack::Kind::kBroken);
  EXPECT_EQ(DecodeAck(AckPacket(0, 0x0801, 5, {1, 2, 3}), Command::kReadMem, 5, 4).kind, Ack::Kind::kBroken);
}

TEST(DecodeAck, RefusesEveryTruncation) {
  const Bytes whole = AckPacket(0, 0x0801, 5, {1, 2, 3, 4});
  for (std::size_t n = 0; n < whole.size(); ++n) {
    const Ack ack = DecodeAck(ByteView(whole).first(n), Command::kReadMem, 5, 4);
    EXPECT_EQ(ack.kind, Ack::Kind::kBroken) << n;
    EXPECT_FALSE(ack.error.empty());
  }
}

TEST(Leader, ThereAndBack) {
  const Leader leader = SomeLeader();
  std::string error;
  const std::optional<Leader> decoded = DecodeLeader(EncodeLeader(leader), error);
  ASSERT_TRUE(decoded) << error;
  EXPECT_EQ(EncodeLeader(*decoded), EncodeLeader(leader));
  EXPECT_EQ(decoded->timestamp_ns, leader.timestamp_ns);
}

TEST(Leader, ReadsOneOfTheField) {
  std::string error;
  const std::optional<Leader> leader = DecodeLeader(ReadVector("u3v_leader_image.bin"), error);
  ASSERT_TRUE(leader) << error;
  EXPECT_EQ(leader->block_id, 51u);
  EXPECT_EQ(leader->payload_type, kImagePayload);
  EXPECT_EQ(leader->width, 3840u);
  EXPECT_EQ(leader->height, 2160u);
}

TEST(Trailer, ReadsOneOfTheFieldThatReportsALoss) {
  std::string error;
  const std::optional<Trailer> trailer = DecodeTrailer(ReadVector("u3v_trailer_image_discarded.bin"), error);
  ASSERT_TRUE(trailer) << error;
  EXPECT_EQ(trailer->status, 0xA100);
  EXPECT_EQ(trailer->height, 1024u);
  EXPECT_EQ(DecodeTrailer(EncodeTrailer(*trailer), error)->valid_payload_size, trailer->valid_payload_size);
}

TEST(LeaderAndTrailer, RefuseEveryTruncationAndAWrongMagic) {
  const Bytes leader = EncodeLeader(SomeLeader()), trailer = EncodeTrailer(MatchingTrailer(SomeLeader()));
  std::string error;
  for (std::size_t n = 0; n < leader.size(); ++n) EXPECT_FALSE(DecodeLeader(ByteView(leader).first(n), error)) << n;
  for (std::size_t n = 0; n < trailer.size(); ++n) EXPECT_FALSE(DecodeTrailer(ByteView(trailer).first(n), error)) << n;
  EXPECT_FALSE(DecodeLeader(trailer, error));
  EXPECT_FALSE(DecodeTrailer(leader, error));
}

TEST(FrameFault, AcceptsAWholeFrameAndNamesTheRuleABrokenOneBreaks) {
  const Leader leader = SomeLeader();
  const Trailer trailer = MatchingTrailer(leader);
  EXPECT_EQ(FrameFault(leader, trailer, 24), "");
  EXPECT_NE(FrameFault(leader, trailer, 23).find("23 bytes"), std::string::npos);

  Trailer other = trailer;
  other.block_id = 8;
  EXPECT_NE(FrameFault(leader, other, 24).find("block 8"), std::string::npos);
  other = trailer;
  other.status = 0xA101;
  EXPECT_NE(FrameFault(leader, other, 24).find("overrun"), std::string::npos);
  other = trailer;
  other.height = 2;
  EXPECT_NE(FrameFault(leader, other, 24), "");
  other.valid_payload_size = 16;
  EXPECT_EQ(FrameFault(leader, other, 16), "") << "a frame of fewer rows is whole if the trailer says so";

  Leader empty = leader;
  empty.width = 0;
  empty.height = other.height = 0xfffffffe;  // rows of nothing: however many there are, no byte is missing
  other.valid_payload_size = 0;
  EXPECT_NE(FrameFault(empty, other, 0).find("without pixels"), std::string::npos);
  empty.width = 0x80000000;  // rows times their bytes is 2^64
  empty.pixel_format = static_cast<std::uint32_t>(PixelFormat::kCoord3dC32f);
  empty.height = other.height = 0x80000000;
  empty.padding_x = 0;
  EXPECT_NE(FrameFault(empty, other, 0), "");

  Leader grey = leader;
  grey.pixel_format = 0x01100007;  // Mono16
  EXPECT_NE(FrameFault(grey, trailer, 24).find("pixel format"), std::string::npos);
}

// A large image is decoded by a table, a small one number by number.
TEST(DecodeDepth, LargeImagesAreRowsOfSmallOnes) {
  constexpr std::uint32_t kColumns = 512, kRows = 200;
  Frame large;
  large.leader.pixel_format = static_cast<std::uint32_t>(PixelFormat::kCoord3dC16);
  large.leader.width = kColumns;
  large.leader.padding_x = 3;
  large.trailer.height = kRows;
  for (std::uint32_t row = 0; row < kRows; ++row) {
    for (std::uint32_t column = 0; column < kColumns; ++column) {
      const std::uint32_t number = 977 * (row * kColumns + column);
      large.payload.push_back(static_cast<std::uint8_t>(number));
      large.payload.push_back(static_cast<std::uint8_t>(number >> 8));
    }
    large.payload.insert(large.payload.end(), 3, 0xff);
  }
  const DepthScale scale{0.02, -3.0, 0.001, 500.0};
  const RangeImage image = DecodeDepth(large, scale);
  ASSERT_EQ(image.depth.size(), std::size_t{kColumns} * kRows);
  int none = 0;
  for (std::uint32_t row = 0; row < kRows; ++row) {
    Frame small = large;
    small.trailer.height = 1;
    small.payload.assign(large.payload.begin() + row * (2 * kColumns + 3), large.payload.begin() + (row + 1) * (2 * kColumns + 3));
    const RangeImage line = DecodeDepth(small, scale);
    for (std::uint32_t column = 0; column < kColumns; ++column) {
      const float depth = image.depth[row * kColumns + column];
      none += std::isnan(depth);
      ASSERT_EQ(std::bit_cast<std::uint32_t>(depth), std::bit_cast<std::uint32_t>(line.depth[column])) << row << " " << column;
    }
  }
  EXPECT_GT(none, 0) << "the offset makes some depths negative, and one number says that there is none";
}

}  // namespace
}  // namespace geond::drivers::u3v
