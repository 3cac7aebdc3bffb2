/* Records what an application draws into a Subpixel capture (.spcap), from C or any language that calls C. The frames
   go to the file as they come: memory stays small, and a crash leaves the frames before it. C99; of the system's
   headers it needs two. capture_format/stream_recorder.hpp is the same for C++; docs/recording.md has examples.

   Calls. Resources may be added at any time, but before the draw that refers to them; draws only between begin_frame
   and end_frame. Everything is copied, so the caller's memory is free after each call. A recorder is not for several
   threads at once; different recorders are.

   Errors. Each call returns a subpixel_status and never ends the process or throws. What is wrong is refused at the
   call that brings it and changes nothing, except that end_frame ends its frame; subpixel_recorder_error() names the
   field. A null pointer where one is needed, a number out of range and a wrong order of calls are such errors; memory
   that can't be read is not found out.

   Structures. Each begins with struct_size, which tells the library which version of it the caller was compiled with:
   have the structure's init function set it with all defaults, then fill in. Arrays, matrices and colours are held in
   the structure; pointers to bytes and texts are needed only during the call. Texts are UTF-8 and end with a zero; a
   null text is an empty one. Flags are 0 or 1. Enumerations are uint32_t in structures, so that their size is known.

   Numbers. Buffers, textures and materials are numbered 0, 1, 2, ... each in the order in which new ones were added;
   SUBPIXEL_NONE stands for "none". Matrices are column-major and take column vectors: element (row r, column c) is
   [4 * c + r]. Lengths are in world units, sizes and offsets in bytes. */
#ifndef SUBPIXEL_RECORDER_H
#define SUBPIXEL_RECORDER_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Of this header: grows with each function or field that is added. What is there keeps its meaning, so a library of a
   higher version serves as well. */
#define SUBPIXEL_RECORDER_VERSION 1

#define SUBPIXEL_NONE 0xffffffffu

/* Of the library that is linked, as SUBPIXEL_RECORDER_VERSION. */
uint32_t subpixel_recorder_version(void);

/* Of the newest version of the format that the library knows, which is that of the files it writes. */
uint32_t subpixel_recorder_format_version(void);

/* "0.1.0": the release of Subpixel that the library is part of. */
const char* subpixel_recorder_release(void);

typedef struct subpixel_recorder subpixel_recorder;

typedef enum subpixel_status {
  SUBPIXEL_OK = 0,
  SUBPIXEL_BAD_ARGUMENT = 1, /* refused: the recorder goes on as if the call had not been made */
  SUBPIXEL_BAD_ORDER = 2,    /* the same, for a call that is not due */
  SUBPIXEL_CANT_WRITE = 3,   /* of the file, a full disk say: all later calls fail, what was written stays */
  SUBPIXEL_NO_MEMORY = 4,    /* for this call: the recorder goes on as if it had not been made */
  SUBPIXEL_FAILED = 5        /* a mistake of Subpixel's own, please report it */
} subpixel_status;

/* What was wrong in the last call of this thread that did not return SUBPIXEL_OK, one line, "what: why: where": a field
   by its name, or a path. Never null; valid until the thread's next call that fails. By thread, because a call that
   creates no recorder has none to ask. */
const char* subpixel_recorder_error(void);

/* ---- The recording ------------------------------------------------------------------------------------------------
 */

typedef struct subpixel_metadata {
  uint32_t struct_size;
  float metres_per_unit; /* 1 */
  const char* title;
  const char* application;    /* what is recorded */
  const char* tool;           /* what records it, with version */
  const char* licence;        /* of the recorded content */
  const char* const* notices; /* what the recorder leaves out or approximates, a sentence each */
  size_t notice_count;
} subpixel_metadata;

typedef struct subpixel_options {
  uint32_t struct_size;
  int32_t zstd_level;    /* 1; 0 to 22, 0: nothing is compressed */
  uint64_t queued_bytes; /* 256 MiB: that may wait to be written before calls wait */
  uint64_t kept_bytes;   /* 256 MiB: of buffers that stay in memory; others are read back when needed */
  uint64_t most_bytes;   /* 8 GiB: of the whole recording, uncompressed, which is what readers take */
} subpixel_options;

/* Sets all fields to the defaults above. `struct_size` is sizeof *metadata, by which the library knows how much of it
   there is. Fails for a null pointer and for a size that no version had. All init functions are like this one. */
subpixel_status subpixel_metadata_init(subpixel_metadata* metadata, size_t struct_size);
subpixel_status subpixel_options_init(subpixel_options* options, size_t struct_size);

/* Begins the recording that finish() will call `path`; until then it is PATH.part, or PATH.2.part and so on where older
   ones are. Null `options` are the defaults. On errors *recorder is null: SUBPIXEL_BAD_ARGUMENT for metadata or
   options, SUBPIXEL_CANT_WRITE when the file can't be made. */
subpixel_status subpixel_recorder_create(const char* path, const subpixel_metadata* metadata,
                                         const subpixel_options* options, subpixel_recorder** recorder);

/* Frees the recorder; null is nothing. Without a successful finish() before, what was recorded so far is left as the
   .part file, of which `subpixel repair` and `subpixel validate` read every frame that was ended. */
void subpixel_recorder_destroy(subpixel_recorder* recorder);

/* Where the frames are until finish(), the same as long as the recorder lives; null for a null recorder. */
const char* subpixel_recorder_part_path(const subpixel_recorder* recorder);

/* Writes what is left to the disk and gives the file its name, over an older one. Inside a frame it is
   SUBPIXEL_BAD_ORDER and nothing happens; else only destroy() may follow, whether or not it succeeded. */
subpixel_status subpixel_recorder_finish(subpixel_recorder* recorder);

/* ---- Resources ----------------------------------------------------------------------------------------------------
 */

/* Adds `size` bytes that vertices, indices or instance matrices of draws are in; none may be null. *buffer gets the
   number for streams and draws, SUBPIXEL_NONE on errors. Bytes that were added before give the number they got then, so
   that an application may hand over its buffers anew for every frame: that costs a hash. */
subpixel_status subpixel_recorder_add_buffer(subpixel_recorder* recorder, const char* name, const void* bytes,
                                             size_t size, uint32_t* buffer);

enum subpixel_texture_format {
  SUBPIXEL_TEXTURE_RGBA8 = 0,      /* 4 * width * height bytes, top row first */
  SUBPIXEL_TEXTURE_IMAGE_FILE = 1, /* a file as it is on disk: PNG, JPEG, TGA, DDS, ...; width and height 0 */
  /* Block-compressed texels of the largest level alone: blocks of 4 x 4 texels in rows from the top, an incomplete one
     at the end of a row or column counting as a whole. Smaller levels are made by the replay. */
  SUBPIXEL_TEXTURE_BC1 = 2,         /* 8 bytes a block */
  SUBPIXEL_TEXTURE_BC2 = 3,         /* 16 */
  SUBPIXEL_TEXTURE_BC3 = 4,         /* 16 */
  SUBPIXEL_TEXTURE_BC4 = 5,         /* 8, unsigned: grey */
  SUBPIXEL_TEXTURE_BC5 = 6,         /* 16, unsigned: x and y of a normal, z is worked out */
  SUBPIXEL_TEXTURE_BC6H_UFLOAT = 7, /* 16; read as 8 bits from 0 to 1, as all textures are */
  SUBPIXEL_TEXTURE_BC6H_SFLOAT = 8, /* 16 */
  SUBPIXEL_TEXTURE_BC7 = 9          /* 16 */
};

enum subpixel_wrap { SUBPIXEL_WRAP_REPEAT = 0, SUBPIXEL_WRAP_CLAMP_TO_EDGE = 1, SUBPIXEL_WRAP_MIRRORED_REPEAT = 2 };
enum subpixel_filter { SUBPIXEL_FILTER_LINEAR = 0, SUBPIXEL_FILTER_NEAREST = 1 };
/* NONE: level 0 always. OF_MEANS: a level's alpha is the mean of the finer level's, as most engines have it; with
   LINEAR and NEAREST it is scaled so that as many texels pass an alpha test as at level 0. */
enum subpixel_mip {
  SUBPIXEL_MIP_LINEAR = 0,
  SUBPIXEL_MIP_NEAREST = 1,
  SUBPIXEL_MIP_NONE = 2,
  SUBPIXEL_MIP_LINEAR_OF_MEANS = 3,
  SUBPIXEL_MIP_NEAREST_OF_MEANS = 4
};

typedef struct subpixel_texture {
  uint32_t struct_size;
  uint32_t format; /* subpixel_texture_format: rgba8 */
  const char* name;
  const void* bytes;
  size_t size;              /* of bytes */
  uint32_t width, height;   /* texels, at most 16384; 0 for an image file, which knows */
  uint32_t srgb;            /* 0; 1: colours are sRGB-encoded, as most base colours and no normals are */
  uint32_t wrap_u, wrap_v;  /* subpixel_wrap: repeat */
  uint32_t magnify, minify; /* subpixel_filter: linear */
  uint32_t mip;             /* subpixel_mip: linear */
} subpixel_texture;

subpixel_status subpixel_texture_init(subpixel_texture* texture, size_t struct_size);

/* *number gets the number for materials, SUBPIXEL_NONE on errors. Equal textures with equal samplers are one. The bytes
   of an image file are not decoded here: `subpixel validate` does. */
subpixel_status subpixel_recorder_add_texture(subpixel_recorder* recorder, const subpixel_texture* texture,
                                              uint32_t* number);

/* Where a texture is read: u' = matrix[0] u + matrix[1] v + matrix[2], v' = matrix[3] u + matrix[4] v + matrix[5]. */
typedef struct subpixel_uv_mapping {
  uint32_t set;    /* 0; 0: the draw's uv, 1: its uv2 */
  float matrix[6]; /* 1 0 0 0 1 0 */
} subpixel_uv_mapping;

enum subpixel_alpha_mode { SUBPIXEL_ALPHA_OPAQUE = 0, SUBPIXEL_ALPHA_TEST = 1, SUBPIXEL_ALPHA_BLEND = 2 };

/* glTF's metallic-roughness. Factors multiply their textures, which are numbers or SUBPIXEL_NONE, the default. */
typedef struct subpixel_material {
  uint32_t struct_size;
  uint32_t alpha_mode; /* subpixel_alpha_mode: opaque */
  const char* name;
  float base_colour[4];                /* 1 1 1 1; linear, within 0 to 1 */
  float emissive[3];                   /* 0 0 0; linear radiance */
  float alpha_cutoff;                  /* 0.5 */
  float metallic;                      /* 0 */
  float roughness;                     /* 0.8 */
  float normal_scale;                  /* 1; of the normal texture's x and y */
  uint32_t two_sided;                  /* 0 */
  uint32_t unlit;                      /* 0; 1: radiance is the base colour, neither light nor shadow */
  uint32_t base_colour_texture;        /* alpha in A */
  uint32_t metallic_roughness_texture; /* G roughness, B metallic */
  uint32_t normal_texture;             /* tangent space, +y up */
  uint32_t emissive_texture;
  subpixel_uv_mapping base_colour_uv, metallic_roughness_uv, normal_uv, emissive_uv;
} subpixel_material;

subpixel_status subpixel_material_init(subpixel_material* material, size_t struct_size);

/* *number gets the number for draws, SUBPIXEL_NONE on errors. Equal materials are not found out: keep the number. */
subpixel_status subpixel_recorder_add_material(subpixel_recorder* recorder, const subpixel_material* material,
                                               uint32_t* number);

/* ---- Frames -------------------------------------------------------------------------------------------------------
 */

/* Shines from a point, with a cone as a spot light: full intensity where the cosine of the angle to the direction is at
   least inner_cosine, none below outer_cosine. */
typedef struct subpixel_point_light {
  uint32_t struct_size;
  float position[3];  /* 0 0 0; world space */
  float intensity[3]; /* 1 1 1; linear: irradiance is intensity / distance^2, windowed to 0 at range */
  float range;        /* 10 */
  uint32_t has_cone;  /* 0 */
  float direction[3]; /* 0 -1 0; the way the light travels, of any length but 0 */
  float inner_cosine; /* 1; above outer_cosine */
  float outer_cosine; /* 0 */
} subpixel_point_light;

enum subpixel_clip_depth {
  SUBPIXEL_CLIP_ZERO_TO_ONE = 0,     /* Vulkan, Direct3D: the near plane is at 0 */
  SUBPIXEL_CLIP_ONE_TO_ZERO = 1,     /* the same reversed: the near plane is at 1 */
  SUBPIXEL_CLIP_MINUS_ONE_TO_ONE = 2 /* OpenGL */
};

typedef struct subpixel_frame {
  uint32_t struct_size;
  uint32_t clip_depth; /* subpixel_clip_depth: one to zero */
  const char* name;
  double time_s;                            /* 0; since any beginning */
  float view[16];                           /* world to view, right-handed, looking down -z: the identity */
  float projection[16];                     /* view to clip: the identity, which is no camera, so set it */
  uint32_t clip_y_up;                       /* 0: Vulkan; 1: OpenGL, Direct3D */
  uint32_t width, height;                   /* 1280 720; pixels it was drawn at, at most 16384 */
  float exposure;                           /* 1 */
  float sky[3];                             /* 0.35 0.5 0.75; linear radiance of what no surface covers */
  float ambient[3];                         /* 0.3 0.35 0.4; linear irradiance / pi from everywhere */
  uint32_t has_sun;                         /* 0 */
  float sun_direction[3];                   /* 0 -1 0; the way the light travels, world space, of any length but 0 */
  float sun_irradiance[3];                  /* 3 3 3; linear, on a surface that faces it */
  uint32_t sun_shadows;                     /* 1 */
  const subpixel_point_light* point_lights; /* point_light_count of them, all of one struct_size */
  size_t point_light_count;                 /* 0 */
} subpixel_frame;

subpixel_status subpixel_point_light_init(subpixel_point_light* light, size_t struct_size);
subpixel_status subpixel_frame_init(subpixel_frame* frame, size_t struct_size);

/* Starts a frame: camera, lights and time. SUBPIXEL_BAD_ORDER while one is begun. */
subpixel_status subpixel_recorder_begin_frame(subpixel_recorder* recorder, const subpixel_frame* frame);

enum subpixel_vertex_format {
  SUBPIXEL_FLOAT32X2 = 0,
  SUBPIXEL_FLOAT32X3 = 1,
  SUBPIXEL_FLOAT32X4 = 2,
  SUBPIXEL_FLOAT16X2 = 3,
  SUBPIXEL_FLOAT16X4 = 4,
  SUBPIXEL_SNORM8X4 = 5,
  SUBPIXEL_SNORM16X4 = 6,
  SUBPIXEL_UNORM16X2 = 7,
  SUBPIXEL_UNORM8X4 = 8,
  SUBPIXEL_UNORM16X4 = 9,
  SUBPIXEL_OCTAHEDRAL_SNORM8 = 10, /* a direction as two snorm8 on an octahedron (Cigolle et al. 2014) */
  SUBPIXEL_OCTAHEDRAL_SNORM16 = 11,
  SUBPIXEL_SNORM10X3_2 = 12, /* 32 bits: x in the lowest ten, w in the highest two */
  SUBPIXEL_UNORM10X3_2 = 13,
  SUBPIXEL_FLOAT11X2_10 = 14, /* 32 bits of unsigned floats: x in the lowest eleven, z in the highest ten */
  SUBPIXEL_FLOAT16X3 = 15,
  SUBPIXEL_SNORM16X2 = 16
};

/* A vertex attribute: element i begins at byte offset + i * stride of the buffer. */
typedef struct subpixel_stream {
  uint32_t buffer; /* SUBPIXEL_NONE: the draw lacks the attribute */
  uint32_t format; /* subpixel_vertex_format: float32x3 */
  uint64_t offset; /* 0; bytes */
  uint32_t stride; /* 0; bytes, at least an element; 0, not for positions: all vertices have the first value */
} subpixel_stream;

enum subpixel_index_type {
  SUBPIXEL_INDEX_NONE = 0,
  SUBPIXEL_INDEX_UINT16 = 1,
  SUBPIXEL_INDEX_UINT32 = 2,
  SUBPIXEL_INDEX_UINT8 = 3
};

/* How indices, or vertices in order, make triangles, whose front faces are counter-clockwise; strips and fans as Vulkan
   numbers their corners. */
enum subpixel_topology { SUBPIXEL_TRIANGLE_LIST = 0, SUBPIXEL_TRIANGLE_STRIP = 1, SUBPIXEL_TRIANGLE_FAN = 2 };

typedef struct subpixel_draw {
  uint32_t struct_size;
  uint32_t material;        /* 0 */
  const char* name;         /* by which the same object is known in other frames */
  subpixel_stream position; /* has to be there */
  subpixel_stream normal;   /* without: of the triangles */
  subpixel_stream uv;       /* (0, 0) is a texture's top left corner */
  subpixel_stream tangent;  /* w: the bitangent's sign */
  subpixel_stream uv2;
  subpixel_stream colour;   /* linear, three or four components; multiplies the base colour, alpha included */
  uint32_t topology;        /* subpixel_topology: a list */
  uint32_t restart;         /* 0; 1, of an indexed strip or fan: the index of all ones begins a new one */
  uint32_t index_type;      /* subpixel_index_type: none */
  uint32_t index_buffer;    /* SUBPIXEL_NONE */
  uint64_t index_offset;    /* 0; bytes */
  uint32_t index_count;     /* 0; indices drawn, or vertices without indices; of a list a multiple of 3 */
  int32_t base_vertex;      /* 0; added to every index */
  uint32_t vertex_count;    /* 0; vertices in the streams: index + base_vertex is below it */
  uint32_t instance_buffer; /* SUBPIXEL_NONE: one instance */
  uint64_t instance_offset; /* 0; bytes */
  uint32_t instance_count;  /* 1; matrices of 16 floats in the instance buffer, without gaps */
  float transform[16];      /* object to world: the identity; instance i is at transform * matrix i */
} subpixel_draw;

subpixel_status subpixel_draw_init(subpixel_draw* draw, size_t struct_size);

/* Adds a draw call to the frame that has begun, SUBPIXEL_BAD_ORDER without one. Checked are all references, that
   streams, indices and matrices lie in their buffers, and that each index is below vertex_count. */
subpixel_status subpixel_recorder_draw(subpixel_recorder* recorder, const subpixel_draw* draw);

/* Ends the frame and hands it to the writing thread. One that a capture can't hold, for its triangles or because it
   passes most_bytes, is SUBPIXEL_BAD_ARGUMENT: whatever the status, the frame has ended, and on errors it is gone with
   its draws, while buffers, textures and materials keep their numbers. The next frame may begin, and finish() writes
   those that were ended without an error. */
subpixel_status subpixel_recorder_end_frame(subpixel_recorder* recorder);

#ifdef __cplusplus
}
#endif

#endif
