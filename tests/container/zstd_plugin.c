/* The zstd filter as a plugin, for h5repack: no package has it. Equal to what users have in that it encodes in one
   go, and so makes other frames than our writer. */
#include <H5PLextern.h>
#include <stdlib.h>
#include <zstd.h>

static size_t filter_zstd(unsigned flags, size_t parameter_count, const unsigned* parameters, size_t stored_bytes,
                          size_t* buffer_bytes, void** buffer) {
  const int is_reading = (flags & H5Z_FLAG_REVERSE) != 0;
  const size_t room =
      is_reading ? (size_t)ZSTD_getFrameContentSize(*buffer, stored_bytes) : ZSTD_compressBound(stored_bytes);
  const int level = parameter_count > 0 ? (int)parameters[0] : 3;
  void* result = malloc(room);
  size_t size;
  if (result == NULL) return 0;
  size = is_reading ? ZSTD_decompress(result, room, *buffer, stored_bytes)
                    : ZSTD_compress(result, room, *buffer, stored_bytes, level);
  if (ZSTD_isError(size)) {
    free(result);
    return 0;
  }
  free(*buffer);
  *buffer = result;
  *buffer_bytes = room;
  return size;
}

static const H5Z_class2_t filter = {H5Z_CLASS_T_VERS, 32015, 1, 1, "zstd", NULL, NULL, &filter_zstd};

H5PL_type_t H5PLget_plugin_type(void) { return H5PL_TYPE_FILTER; }
const void* H5PLget_plugin_info(void) { return &filter; }
