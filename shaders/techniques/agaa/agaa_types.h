// What host and shaders of the aggregate technique share.
#ifndef SUBPIXEL_AGAA_TYPES_H
#define SUBPIXEL_AGAA_TYPES_H

#define AGAA_MAX_AGGREGATES 4

// Specialization constant 8.
#define AGAA_FLOAT 1u                // sums of 32-bit floats, not the paper's fixed point
#define AGAA_SGGX 2u                 // second moments of the normals as well
#define AGAA_ROUGHNESS_IN_NORMAL 4u  // roughness shortens the normals, and is not kept by itself
#define AGAA_DISTANCE_ALONG_VIEW 8u  // face normals: the eye looks along +z of view space

#endif
