#include "container/descriptions.hpp"

#include <algorithm>
#include <iterator>

#include "container/chunk.hpp"

namespace colossus::container {
namespace {

using hdf5::Blame;

// An object, or a field or row of a table.
struct Meaning {
  std::string_view of;
  std::string_view name;
  std::string_view text;
};

constexpr Meaning kTitles[] = {
    {"", "/", "Multiresolution triangle mesh"},
    {"", "nodes", "Node table"},
    {"", "lattice", "Integer lattice of all positions"},
    {"", "chunks", "Payloads of the nodes"},
    {"", "options", "Options of the build"},
    {"", "parameters", "Parameters of the scheme"},
    {"", "measures", "Measures of the input and of the finest level"},
    {"", "inputs", "Input files"},
    {"", "counts", "Counts of the input and of the finest level"},
    {"", "levels", "Statistics per level"},
};

// These texts are stored, so their bytes are part of the container. They name both schemes and what each
// makes of a field, since whoever opens a container with an HDF5 tool has nothing else; the code asks no
// scheme here.
constexpr Meaning kDescriptions[] = {
    {"", "/",
     "One surface at several levels of detail. /nodes has one row per node of the hierarchy, from the "
     "coarsest "
     "level on, and says where the node's bytes lie; /chunks holds these bytes. Attributes: format: always "
     "colossus. schema_version: major, minor; a reader refuses larger major versions. scheme: diamonds (a "
     "node is "
     "all tetrahedra around one edge) or blocks (a node is a cube of an octree). attributes: what vertices "
     "carry, "
     "bit 0 normals, bit 1 colours."},
    {"", "nodes",
     "One row per node, ascending by level and centre. Read stored_bytes bytes at offset, or the chunk "
     "chunk_index of /chunks/class_<chunk_class>: one zstd frame, whose first payload_bytes bytes are the "
     "node's "
     "mesh. xxh3: XXH3-64 (seed 0) of the table's bytes. The attributes field_<name> explain the fields."},
    {"", "lattice",
     "origin: world position of lattice point (0, 0, 0); unit: that of the input. step: world length of one "
     "lattice unit; unit: that of the input. root_bits: the root cube is [0, 2^root_bits]^3 in lattice "
     "units. "
     "position_bits: b; diamonds: the four weights of a vertex sum to 2^b; blocks: a cube of the deepest "
     "level "
     "has sides of 2^b lattice units."},
    {"", "chunks",
     "One dataset per capacity class that is in use. A chunk is one zstd frame (filter 32015); decoded it "
     "has "
     "payload_bytes bytes of one node, and zeros behind them."},
    {"", "options",
     "The options of the build that shape the bytes. xxh3: XXH3-64 (seed 0) of the table's bytes."},
    {"", "parameters",
     "Numbers that the rules of the scheme need. xxh3: XXH3-64 (seed 0) of the table's bytes."},
    {"", "measures",
     "Real numbers about the input and the finest level. xxh3: XXH3-64 (seed 0) of the table's bytes."},
    {"", "inputs",
     "The files that were read, in the order of reading. xxh3: XXH3-64 (seed 0) of the table's bytes."},
    {"", "counts",
     "Numbers of things in the input and in the finest level. xxh3: XXH3-64 (seed 0) of the table's bytes."},
    {"", "levels",
     "One row per level, from the root on. Unless it says otherwise a value is the sum over the nodes of "
     "that "
     "level. xxh3: XXH3-64 (seed 0) of the table's bytes."},
};

constexpr Meaning kUnits[] = {
    {"", "/",
     "World coordinates and lengths have the unit of the input files, which do not state it; world = origin "
     "+ "
     "step * lattice position, with origin and step of /lattice"},
    {"", "nodes",
     "error, bounds: that of the input; center: lattice units; offset, stored_bytes, payload_bytes: bytes; "
     "all "
     "others: none"},
    {"", "lattice", "origin, step: that of the input; root_bits, position_bits: bits"},
    {"", "chunks", "bytes"},
    {"", "options", "as the attributes row_<name> say"},
    {"", "parameters", "as the attributes row_<name> say"},
    {"", "measures", "areas: square lattice units; coordinates: that of the input"},
    {"", "inputs", "bytes: bytes"},
    {"", "counts", "numbers of things"},
    {"", "levels",
     "error, quantization_error: that of the input; all that end in _bytes: bytes; all others: numbers of "
     "things"},
};

constexpr Meaning kFields[] = {
    {"nodes", "level", "Depth of the node: 0 is the root, the coarsest; no unit"},
    {"nodes", "center", "x, y, z of the node's centre; unit: lattice units"},
    {"nodes", "tetra_mask",
     "Bit p: the tetrahedron at place p exists, the input's surface crosses it; blocks: 1; no unit"},
    {"nodes", "flags",
     "Bit 0: leaf, nothing is finer; bit 1: leaf with more triangles than the limit, because no split would "
     "thin "
     "it out; no unit"},
    {"nodes", "vertices", "Vertices in the payload, over all its tetrahedra; unit: vertices"},
    {"nodes", "triangles", "Triangles in the payload, over all its tetrahedra; unit: triangles"},
    {"nodes", "error",
     "Upper estimate of the distance, both ways, between the node's surface and the part of the input that "
     "it "
     "stands for; never smaller than a child's; unit: that of the input"},
    {"nodes", "bounds",
     "Box of all vertices of the payload: minimum x, y, z, maximum x, y, z; unit: that of the input"},
    {"nodes", "chunk_class", "The payload is in the dataset /chunks/class_<chunk_class>; no unit"},
    {"nodes", "chunk_index", "Number of the chunk in that dataset, in the order of the rows; no unit"},
    {"nodes", "offset",
     "Of the stored bytes in the file as it was written. After h5repack or h5copy it does not hold: use "
     "chunk_index; unit: bytes"},
    {"nodes", "stored_bytes", "Size of the zstd frame in the file; unit: bytes"},
    {"nodes", "payload_bytes", "Size of the payload, which the frame's content begins with; unit: bytes"},
    {"nodes", "checksum", "XXH3-64 (seed 0) of the stored bytes; no unit"},

    {"options", "name", "Name of the option"},
    {"options", "value", "Its value, as text"},
    {"parameters", "name", "Name of the parameter"},
    {"parameters", "value", "Its value; for the unit see the attribute row_<name>"},
    {"measures", "name", "Name of the measure"},
    {"measures", "value", "Its value; for the unit see the attribute row_<name>"},
    {"counts", "name", "Name of the count"},
    {"counts", "value", "How many; see the attribute row_<name>"},
    {"inputs", "name", "Name of the file, without folders"},
    {"inputs", "bytes", "Size of the file; unit: bytes"},
    {"inputs", "hash", "XXH3-128 (seed 0) of the file's content, 32 hexadecimal digits, high half first"},

    {"levels", "level", "Number of the level, 0 for the root; no unit"},
    {"levels", "nodes", "Nodes of the level; unit: nodes"},
    {"levels", "leaves", "Those that are leaves; unit: nodes"},
    {"levels", "vertices", "Vertices in the payloads; unit: vertices"},
    {"levels", "triangles", "Triangles in the payloads; unit: triangles"},
    {"levels", "payload_bytes", "Size of the payloads; unit: bytes"},
    {"levels", "stored_bytes", "Size of the zstd frames; unit: bytes"},
    {"levels", "connectivity_bytes", "Part of stored_bytes that triangles take; unit: bytes"},
    {"levels", "position_bytes", "Part of stored_bytes that positions take; unit: bytes"},
    {"levels", "normal_bytes", "Part of stored_bytes that normals take; unit: bytes"},
    {"levels", "color_bytes", "Part of stored_bytes that colours take; unit: bytes"},
    {"levels", "parent_bytes", "Part of stored_bytes that parents of vertices take; unit: bytes"},
    {"levels", "error", "Greatest error of the level's nodes; unit: that of the input"},
    {"levels", "quantization_error",
     "Greatest distance by which the last rounding of positions has moved a vertex; unit: that of the input"},
    {"levels", "initial_triangles",
     "Triangles of the finer level that the level's inner nodes were simplified from; unit: triangles"},
    {"levels", "target_triangles", "Triangles that simplification aimed at; unit: triangles"},
    {"levels", "reached_triangles", "Triangles that simplification arrived at; unit: triangles"},
    {"levels", "initial_vertices",
     "Vertices of the finer level that the level's inner nodes were simplified from; unit: vertices"},
    {"levels", "locked_vertices", "Those that simplification was not allowed to touch; unit: vertices"},
    {"levels", "angle_below_5", "Triangles whose smallest angle is below 5 degrees; unit: triangles"},
    {"levels", "angle_below_15", "Triangles whose smallest angle is below 15 degrees; unit: triangles"},
    {"levels", "angle_below_30", "Triangles whose smallest angle is below 30 degrees; unit: triangles"},
    {"levels", "inconsistent_edges",
     "Edges that exactly two triangles of one tetrahedron (diamonds) or cube (blocks) use, both in the same "
     "direction; edges are equal where their ends have equal positions; unit: edges"},
};

constexpr Meaning kRows[] = {
    {"options", "leaf_triangles",
     "Most triangles per leaf tetrahedron; of blocks: most on average per cube of the deepest level"},
    {"options", "position_bits", "position_bits of /lattice"},
    {"options", "codec", "How payloads are encoded: predict, zstd or paper"},
    {"options", "tolerance",
     "Largest error of the finest level that was asked for; it has chosen position_bits; unit: that of the "
     "input"},
    {"options", "keep_outliers",
     "true: a few far corners were accepted although they make the lattice coarse"},
    {"options", "drop_textures",
     "true: the input had texture coordinates or materials, which are not stored"},
    {"options", "lenient", "true: what many writers do wrong was let pass, with a warning"},

    {"parameters", "block_size",
     "Cubes along each axis of the blocks in which levels were simplified; unit: cubes"},
    {"parameters", "sigma0",
     "At level l a vertex is at most sigma0 * 2^-(l+1) from its parent, and an edge at most sigma0 * 2^-l "
     "long, in "
     "the maximum norm; unit: sides of the root cube"},

    {"measures", "input_area",
     "Area of the input on the lattice, without degenerate, duplicate and opposite triangles; unit: square "
     "lattice "
     "units"},
    {"measures", "finest_area",
     "Area of all leaves, from their stored positions; unit: square lattice units"},
    {"measures", "min_x", "Least x of the vertices that the input's triangles use; unit: that of the input"},
    {"measures", "min_y", "Least y of the vertices that the input's triangles use; unit: that of the input"},
    {"measures", "min_z", "Least z of the vertices that the input's triangles use; unit: that of the input"},
    {"measures", "max_x",
     "Greatest x of the vertices that the input's triangles use; unit: that of the input"},
    {"measures", "max_y",
     "Greatest y of the vertices that the input's triangles use; unit: that of the input"},
    {"measures", "max_z",
     "Greatest z of the vertices that the input's triangles use; unit: that of the input"},

    {"counts", "vertices", "Vertices as read, used or not"},
    {"counts", "triangles", "Triangles as read; faces with more corners count as the triangles of a fan"},
    {"counts", "polygons", "Faces with more than three corners"},
    {"counts", "small_faces", "Faces with fewer than three corners; dropped"},
    {"counts", "degenerate", "Triangles with two corners at one position of the input; dropped"},
    {"counts", "collapsed",
     "Triangles with two corners that only the lattice, or the grid of blocks, lets coincide; the surface "
     "goes on without them, or two triangles back to back stand for them"},
    {"counts", "duplicate",
     "Triangles over the same three corners as an earlier one, turned the same way; dropped"},
    {"counts", "opposite", "Triangles over the same three corners as an earlier one, turned over; dropped"},
    {"counts", "collinear", "Triangles with three different corners that lie exactly on one line; kept"},
    {"counts", "border_edges", "Edges of the input, after what is dropped, that one triangle uses"},
    {"counts", "nonmanifold_edges",
     "Edges of the input, after what is dropped, that more than two triangles use"},
    {"counts", "inconsistent_edges",
     "Edges of the input that exactly two triangles use, both in the same direction"},
    {"counts", "merged_vertices", "Vertices at a position that another vertex has, too"},
    {"counts", "attribute_seams", "Positions whose vertices had different attributes, which were averaged"},
    {"counts", "leaves_above_limit", "Leaves with more triangles than leaf_triangles"},
    {"counts", "split_edges",
     "Edges of the input that were too long for their cubes, and were split (blocks)"},
    {"counts", "finest_triangles", "Triangles of all leaves"},
    {"counts", "finest_border_edges",
     "Edges of the finest level, welded by exact position, that one triangle uses"},
    {"counts", "finest_nonmanifold_edges",
     "Edges of the finest level, welded by exact position, that more than two triangles use"},
    {"counts", "area_differs",
     "1: finest_area differs from input_area by more than a thousandth although positions have 12 bits or "
     "more, as the builder has found and said; else 0"},
};

template <std::size_t N>
std::string_view find(const Meaning (&meanings)[N], std::string_view of, std::string_view name) {
  const auto found = std::find_if(std::begin(meanings), std::end(meanings),
                                  [&](const Meaning& m) { return m.of == of && m.name == name; });
  return found == std::end(meanings) ? std::string_view() : found->text;
}

}  // namespace

void keep_attributes_in_header(const Blame& blame, hid_t properties) {
  constexpr unsigned kMost = 255;
  blame.check(H5Pset_attr_phase_change(properties, kMost, kMost - 1), "cannot set where attributes go");
}

void write_text_attribute(const Blame& blame, hid_t object, const std::string& name,
                          const std::string& text) {
  write_attribute(blame, object, name, FieldType::kText, static_cast<std::uint32_t>(text.size()),
                  text.data());
}

std::string_view field_meaning(std::string_view table, std::string_view field) {
  return find(kFields, table, field);
}

std::string_view row_meaning(std::string_view table, std::string_view row) { return find(kRows, table, row); }

void describe(const Blame& blame, hid_t object, std::string_view name) {
  write_text_attribute(blame, object, "title", std::string(find(kTitles, "", name)));
  write_text_attribute(blame, object, "description", std::string(find(kDescriptions, "", name)));
  write_text_attribute(blame, object, "units", std::string(find(kUnits, "", name)));
}

void describe_table(const Blame& blame, hid_t object, std::string_view table,
                    const std::vector<Field>& fields, const std::vector<std::string>& rows,
                    const std::vector<NamedText>& meanings) {
  describe(blame, object, table);
  for (const Field& field : fields)
    if (const std::string_view text = field_meaning(table, field.name); !text.empty())
      write_text_attribute(blame, object, "field_" + field.name, std::string(text));
  const auto meaning_of = [&](const std::string& row) -> std::string_view {
    if (const std::string_view text = row_meaning(table, row); !text.empty()) return text;
    const auto found = std::find_if(meanings.begin(), meanings.end(),
                                    [&](const NamedText& meaning) { return meaning.name == row; });
    return found == meanings.end() ? std::string_view() : found->value;
  };
  for (const std::string& row : rows)
    if (const std::string_view text = meaning_of(row); !text.empty())
      write_text_attribute(blame, object, "row_" + row, std::string(text));
}

void describe_chunks(const Blame& blame, hid_t object, std::uint32_t capacity_class) {
  write_text_attribute(blame, object, "title",
                       fmt::format("Payloads in chunks of {} bytes", class_capacity(capacity_class)));
  write_text_attribute(
      blame, object, "description",
      "One chunk per node, in the order of the rows of /nodes with this chunk_class. A chunk is one "
      "zstd frame (filter 32015). Decoded it is the payload of the node, whose layout the "
      "documentation says, and zeros up to the chunk's size.");
  write_text_attribute(blame, object, "units", "bytes");
}

void describe_file(const Blame& blame, hid_t root) {
  write_text_attribute(blame, root, "producer", kProducerName);
  write_text_attribute(blame, root, "producer_version", core::release_version());
  write_text_attribute(blame, root, "documentation", "schemas/container.md of the producer's sources");
  describe(blame, root, "/");
}

}  // namespace colossus::container
