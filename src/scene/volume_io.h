// Volume files: raw samples, NRRD (.nrrd, .nhdr) and MetaImage (.mha, .mhd).
//
// Of NRRD: three dimensions; encodings raw and gzip; spacings, or space directions along the axes
// with space origin, or axis mins and maxs with centerings; right-handed spaces; a data file beside
// the header or in a folder below it; byte skip. Source: teem's "Definition of NRRD File Format".
// Of MetaImage: three dimensions, one channel, binary, plain or compressed; ElementDataFile LOCAL
// or a file as above; HeaderSize. Samples uint8, uint16 or float32. What else a header says is
// either refused, where it would change the volume, or listed in `unused_fields`.
#pragma once

#include "scene/volume.h"

#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

struct VolumeFile {
  Volume volume;
  SampleType type = SampleType::kUint8;
  std::filesystem::path data_file;         // where the samples lie: the file itself, or another
  std::vector<std::string> unused_fields;  // of the header
};

// By its extension: raw, nrrd, nhdr, mha, mhd.
bool IsVolumeFile(const std::filesystem::path& path);
// True where the file says nothing of its own layout: raw.
bool NeedsLayout(const std::filesystem::path& path);

// The file's size must be what the layout takes.
VolumeFile ReadRawVolume(const std::filesystem::path& path, const VolumeLayout& layout,
                         const ValueRange& range = std::nullopt);
// NRRD or MetaImage, by the extension.
VolumeFile ReadVolume(const std::filesystem::path& path, const ValueRange& range = std::nullopt);
// As ReadVolume; `file` holds the bytes of `path`. Reads the data file beside it, if that is told.
VolumeFile ParseVolume(std::vector<uint8_t> file, const std::filesystem::path& path,
                       const ValueRange& range = std::nullopt);
// What the header of a NRRD or MetaImage says, checked; its samples are not read.
VolumeLayout ReadVolumeLayout(const std::filesystem::path& path);
// All throw DataError naming the file and the field or line. Memory is taken for no more samples
// than the file's size allows.

// Files that a header names: the one with the samples, where that is another; from the header
// alone.
std::vector<std::filesystem::path> FilesNamedByVolume(const std::filesystem::path& path);

}  // namespace tetrec
