// Visible fragments once they are lit: a fragment's words become those of its value and of how many samples show it.
// Writes: the lists. Needs fragment_lists.glsl before it.
#ifndef SUBPIXEL_LISTED_VALUES_GLSL
#define SUBPIXEL_LISTED_VALUES_GLSL

// `shown`: the samples that show the fragment.
void store_listed_value(ListAddresses lists, uint number, vec3 value, uvec2 shown) {
  lists.fragments.fragment[number] = uvec4(floatBitsToUint(value), uint(bitCount(shown.x) + bitCount(shown.y)));
}

#endif
