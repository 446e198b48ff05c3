#pragma once
#include <string>

/// The recordings at 30 Hz that come with the project, 90 frames of walking and more of sitting, and the room of each.
inline const std::string kWalk = INHABIT_SOURCE_DIR "/examples/data/walk.npz",
                         kRoom = INHABIT_SOURCE_DIR "/examples/data/walk_room.glb",
                         kSit = INHABIT_SOURCE_DIR "/examples/data/sit.npz",
                         kSitRoom = INHABIT_SOURCE_DIR "/examples/data/sit_room.glb";
