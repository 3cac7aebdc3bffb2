/* Records 100 frames of a spinning pyramid into the file that is named. */
#include <math.h>
#include <stdio.h>

#include "subpixel_recorder.h"

static int failed(subpixel_status status) {
  if (status != SUBPIXEL_OK) fprintf(stderr, "%s\n", subpixel_recorder_error());
  return status != SUBPIXEL_OK;
}

static int record(subpixel_recorder* recorder) {
  static const float corners[5][3] = {{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}, {0, 1.5f, 0}};
  static const uint16_t triangles[18] = {0, 4, 1, 1, 4, 2, 2, 4, 3, 3, 4, 0, 0, 1, 2, 0, 2, 3};
  subpixel_material gold;
  subpixel_draw pyramid;
  subpixel_frame frame;
  int f;

  subpixel_material_init(&gold, sizeof gold);
  gold.name = "gold";
  gold.base_colour[1] = 0.7f, gold.base_colour[2] = 0.3f;
  gold.metallic = 1, gold.roughness = 0.3f;
  subpixel_draw_init(&pyramid, sizeof pyramid);
  pyramid.name = "pyramid";
  if (failed(subpixel_recorder_add_material(recorder, &gold, &pyramid.material)) ||
      failed(subpixel_recorder_add_buffer(recorder, "corners", corners, sizeof corners, &pyramid.position.buffer)) ||
      failed(subpixel_recorder_add_buffer(recorder, "triangles", triangles, sizeof triangles, &pyramid.index_buffer)))
    return 1;
  pyramid.position.stride = sizeof corners[0], pyramid.vertex_count = 5;
  pyramid.index_type = SUBPIXEL_INDEX_UINT16, pyramid.index_count = 18;

  subpixel_frame_init(&frame, sizeof frame); /* reversed depth, the far plane at infinity, Vulkan's clip space */
  frame.view[13] = -0.5f, frame.view[14] = -4;
  frame.projection[0] = 1, frame.projection[5] = -16 / 9.0f;
  frame.projection[10] = 0, frame.projection[11] = -1, frame.projection[14] = 0.1f, frame.projection[15] = 0;
  frame.has_sun = 1, frame.sun_direction[0] = -0.5f, frame.sun_direction[2] = -0.7f;
  for (f = 0; f < 100; ++f) {
    pyramid.transform[0] = pyramid.transform[10] = cosf(0.0628f * (float)f);
    pyramid.transform[8] = -(pyramid.transform[2] = -sinf(0.0628f * (float)f));
    frame.time_s = f / 60.0;
    if (failed(subpixel_recorder_begin_frame(recorder, &frame)) || failed(subpixel_recorder_draw(recorder, &pyramid)) ||
        failed(subpixel_recorder_end_frame(recorder)))
      return 1;
  }
  return failed(subpixel_recorder_finish(recorder));
}

int main(int argc, char** argv) {
  subpixel_recorder* recorder = NULL;
  subpixel_metadata metadata;
  subpixel_metadata_init(&metadata, sizeof metadata);
  metadata.title = "Spinning pyramid", metadata.tool = "spinning.c";
  int result = argc != 2 || failed(subpixel_recorder_create(argv[1], &metadata, NULL, &recorder)) || record(recorder);
  subpixel_recorder_destroy(recorder);
  return result;
}
