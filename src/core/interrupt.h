// Requests to stop work. Work checks them through a CancellationScope (core/parallel.h).
#pragma once
#include "glowworm/interrupt.h"
