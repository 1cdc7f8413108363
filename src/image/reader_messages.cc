#include "image/reader_messages.h"

#include <vector>

#include "core/archive.h"

namespace glowworm {

namespace {

template <typename Archive>
void transfer_header(Archive& archive, ImageFileHeader& h) {
  transfer_all(archive, h.width, h.height, h.x0, h.y0, h.whole_width, h.whole_height, h.channels, h.alpha_channel);
  transfer_enum(archive, h.type, SampleType::single);
  transfer_enum(archive, h.transfer.kind, TransferFunction::Kind::power);
  transfer_all(archive, h.transfer.exponent, h.other_primaries, h.channel_names);
  std::vector<std::string> texts;
  for (const auto& [key, text] : h.metadata) texts.insert(texts.end(), {key, text});
  transfer(archive, texts);
  for (std::size_t i = 1; i < texts.size(); i += 2) h.metadata[texts[i - 1]] = texts[i];
}

template <typename Archive>
void transfer_answer(Archive& archive, ReaderAnswer& a) {
  transfer_all(archive, a.done, a.message);
  transfer_header(archive, a.header);
  transfer_all(archive, a.depth, a.tile_height, a.unpacks_whole);
}

}  // namespace

std::string encode_answer(const ReaderAnswer& answer) {
  std::string bytes;
  ArchiveWriter writer([&](const void* data, std::size_t size) { bytes.append(static_cast<const char*>(data), size); });
  transfer_answer(writer, const_cast<ReaderAnswer&>(answer));  // a writer does not change the answer
  return bytes;
}

ReaderAnswer decode_answer(std::string_view bytes) {
  ArchiveReader reader(std::as_bytes(std::span(bytes)));
  ReaderAnswer answer;
  transfer_answer(reader, answer);
  const ImageFileHeader& header = answer.header;
  if (!reader.at_end()) fail_transfer("it does not end where it should");
  if (header.channel_names.size() != static_cast<std::size_t>(header.channels) ||
      header.alpha_channel >= header.channels || header.alpha_channel < -1)
    fail_transfer("its channels contradict each other");
  return answer;
}

}  // namespace glowworm
