// Frames of a sequence, and pictures with motion blur, of `glowworm render`: several jobs that share their photons.
#pragma once
#include <memory>

#include "apps/output_files.h"
#include "apps/render_outputs.h"
#include "apps/render_picture.h"
#include "apps/sequence.h"
#include "apps/tev_stream.h"
#include "import/import.h"
#include "share/ranks.h"

namespace glowworm {

/// Throws CommandLineError if options do not go with one picture with motion blur.
void check_blur(const RenderOptions& o, bool has_ranks);

/// The frames of the options, or the one picture with motion blur.
Sequence sequence_of(RenderOptions& o, const Opened& opened, const std::shared_ptr<SceneMotion>& motion);

/// Renders one picture with motion blur, and returns the exit status. Throws CommandLineError if an option does not go
/// with it, whether the shutter comes from an option or from the file. @param ranks share the work; null: none
int render_blurred(const RenderOptions& o, const Opened& opened, Sequence& sequence, OutputFiles& files, TevStream& tev,
                   const std::shared_ptr<Ranks>& ranks);

/// Renders a sequence: all of it, a part, or by ranks. Returns the exit status.
int render_sequence(RenderOptions& o, const Opened& opened, OutputFiles& files, TevStream& tev,
                    const std::shared_ptr<SceneMotion>& motion, const std::shared_ptr<Ranks>& ranks);

}  // namespace glowworm
