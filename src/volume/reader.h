// Readers of volume files: raw samples, NRRD (.nrrd, .nhdr) and MetaImage (.mha, .mhd).
//
// Supported in NRRD: three dimensions; encodings raw and gzip; spacings, or space directions along
// the axes with space origin, or axis mins and maxs with centerings; right-handed spaces; a data
// file beside the header or in a folder below it; byte skip. Source: teem's "Definition of NRRD
// File Format". Supported in MetaImage: three dimensions, one channel, binary, plain or compressed;
// ElementDataFile LOCAL or a file as above; HeaderSize. Samples are uint8, uint16, int16 or
// float32. Anything else in a header is refused if it would change the volume, otherwise listed in
// `unused_fields`.
#pragma once

#include "volume/volume.h"

#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

struct VolumeFile {
  Volume volume;
  SampleType type = SampleType::kUint8;
  std::filesystem::path data_file;         // contains the samples: the file itself or another
  std::vector<std::string> unused_fields;  // of the header
};

// Goes by the extension: raw, nrrd, nhdr, mha or mhd.
bool IsVolumeFile(const std::filesystem::path& path);
// True if the file does not specify its own layout: raw.
bool NeedsLayout(const std::filesystem::path& path);

// All readers throw DataError naming the file and the field or line. They allocate memory for no
// more samples than the file's size allows.

// The file must have exactly the size of the layout.
VolumeFile ReadRawVolume(const std::filesystem::path& path, const VolumeLayout& layout,
                         const ValueRange& range = std::nullopt);
// NRRD or MetaImage, by the extension.
VolumeFile ReadVolume(const std::filesystem::path& path, const ValueRange& range = std::nullopt);
// Like ReadVolume, from the bytes of `path`. Reads the data file beside it if the header names one.
VolumeFile ParseVolume(std::vector<uint8_t> file, const std::filesystem::path& path,
                       const ValueRange& range = std::nullopt);
// The checked layout from the header of a NRRD or MetaImage; the samples are not read.
VolumeLayout ReadVolumeLayout(const std::filesystem::path& path);
// The files that a header names: the one with the samples, if that is another. Reads only the
// header.
std::vector<std::filesystem::path> FilesNamedByVolume(const std::filesystem::path& path);

}  // namespace tetrec
