// Headers of MetaImage files.
#include "core/error.h"
#include "core/lower_case.h"
#include "volume/header.h"

#include <fmt/format.h>

#include <cmath>

namespace tetrec::internal {
namespace {

SampleType MetaType(const HeaderField& field) {
  const std::string& type = field.text;
  if (type == "MET_UCHAR") return SampleType::kUint8;
  if (type == "MET_USHORT") return SampleType::kUint16;
  if (type == "MET_SHORT") return SampleType::kInt16;
  if (type == "MET_FLOAT") return SampleType::kFloat32;
  field.Fail("MET_UCHAR, MET_USHORT, MET_SHORT or MET_FLOAT; convert the samples to one of these");
}

void RefuseTurnedAxes(const HeaderField& matrix) {
  const std::vector<std::string_view> words = Words(matrix.text);
  if (words.size() != 9) matrix.Fail("nine numbers");
  for (size_t i = 0; i < words.size(); ++i) {
    constexpr double kRounding = 1e-6;
    const double expected = i % 4 == 0 ? 1 : 0;
    if (!(std::abs(matrix.FiniteFrom(words[i], "nine numbers") - expected) <= kRounding)) {
      matrix.Fail("1 0 0 0 1 0 0 0 1: rotated axes are not supported");
    }
  }
}

SamplePlacement ReadMetaPlacement(VolumeHeader& header, const HeaderField& data_file) {
  SamplePlacement placement;
  if (const HeaderField* binary = header.Find("BinaryData"); binary != nullptr && !binary->Flag()) {
    binary->Fail("True: samples as text are not supported");
  }
  if (const HeaderField* compressed = header.Find("CompressedData")) {
    placement.compressed = compressed->Flag();
  }
  header.Find("CompressedDataSize");  // not needed: the stream marks its own end
  if (const HeaderField* size = header.Find("HeaderSize")) {
    const int64_t skip = size->Integer("a number of bytes, or -1 for data at the end of the file");
    if (skip < -1) size->Fail("a number of bytes, or -1 for data at the end of the file");
    placement.skip_to_samples = skip == -1 && !placement.compressed;
    if (skip == -1 && placement.compressed) size->Fail("0 or more for compressed data");
    if (skip > 0) placement.skip = uint64_t(skip);
  }
  const bool is_list = data_file.text.starts_with("LIST") ||
                       data_file.text.find('%') != std::string::npos || data_file.text.empty();
  if (is_list) data_file.Fail("LOCAL or one file (lists and patterns of files are not supported)");
  if (Lower(data_file.text) != "local") placement.data_file = data_file.FileInside();
  return placement;
}

}  // namespace

ParsedVolumeHeader ParseMetaImageHeader(std::span<const uint8_t> bytes, const std::string& name) {
  HeaderLines lines(bytes, name);
  VolumeHeader header(name);
  bool ended = false;  // by ElementDataFile, which is the last field
  while (!ended) {
    const std::optional<std::string_view> line = lines.Next();
    if (!line) break;
    if (line->empty() || (*line)[0] == '#') continue;
    const size_t equals = line->find('=');
    if (equals == std::string_view::npos) {
      throw DataError(
          fmt::format("{}, line {}: is not a field (Name = value)", name, lines.number()));
    }
    const std::string field(Trimmed(line->substr(0, equals)));
    header.Add(field, Trimmed(line->substr(equals + 1)), lines.number());
    ended = field == "ElementDataFile";
  }
  if (const HeaderField* kind = header.Find("ObjectType");
      kind != nullptr && kind->text != "Image") {
    kind->Fail("Image");
  }
  const HeaderField& dimensions = header.Get("NDims");
  if (dimensions.Integer("a number") != 3) dimensions.Fail("3");
  const HeaderField* channels = header.Find("ElementNumberOfChannels");
  if (channels != nullptr && channels->Integer("a number") != 1) channels->Fail("1");

  ParsedVolumeHeader parsed;
  VolumeLayout& layout = parsed.layout;
  layout.size = header.Get("DimSize").Size();
  layout.type = MetaType(header.Get("ElementType"));
  if (const HeaderField* spacing = header.FindAny({"ElementSpacing", "ElementSize"})) {
    layout.spacing = spacing->Vector3("three numbers");
  }
  if (const HeaderField* origin = header.FindAny({"Offset", "Origin", "Position"})) {
    layout.origin = origin->Vector3("three numbers");
  }
  for (const char* matrix : {"TransformMatrix", "Rotation", "Orientation"}) {
    if (const HeaderField* field = header.Find(matrix)) RefuseTurnedAxes(*field);
  }
  if (const HeaderField* order =
          header.FindAny({"ElementByteOrderMSB", "BinaryDataByteOrderMSB"})) {
    layout.big_endian = order->Flag();
  }
  parsed.placement = ReadMetaPlacement(header, header.Get("ElementDataFile"));
  parsed.header_bytes = lines.position();
  parsed.unused_fields = header.Unused();
  return parsed;
}

}  // namespace tetrec::internal
