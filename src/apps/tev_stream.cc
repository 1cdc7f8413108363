#include "apps/tev_stream.h"

#include <exception>

#include "control/job_report.h"
#include "core/log.h"
#include "film/output.h"

namespace glowworm {

TevStream::TevStream(const std::string& address) {
  if (!address.empty()) connection_ = std::make_unique<TevConnection>(address);
}

void TevStream::show(const Job& job) {
  if (!connection_ || job.progress() == shown_progress_) return;
  shown_progress_ = job.progress();
  if (shown_progress_ == 0) return;
  const DiskMemory::Scope scope(job.disk(), DiskMemory::kLeastOfChannels);
  try {
    connection_->show(job.scene().name(), make_image(job.snapshot(), job));
  } catch (const std::exception& error) {
    warn(error.what());
    connection_.reset();
  }
}

}  // namespace glowworm
