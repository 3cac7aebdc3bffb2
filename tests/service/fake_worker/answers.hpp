// What the made-up worker answers when it is asked something about captures instead of replaying one. Arguments are
// those of the command line; each returns the exit code.
#pragma once

#include <string>
#include <vector>

namespace subpixel::tests {

int info(const std::string& path);
// What `info --draws --seen` adds: a sky over two draws, left and right. Frames above 4000 are refused.
int view(const std::vector<std::string>& arguments);
// The story of a pixel whose options are among the arguments. With x above 4000 it is refused.
int tell(const std::vector<std::string>& arguments);
// What `subpixel diff` says: of captures with other `draws` the added ones, and one that changed.
int differ(const std::vector<std::string>& arguments);

}  // namespace subpixel::tests
