/* Quilting: blocks side by side, as mode fast and mode paper lay them. */
#pragma once

#include "tiling/best.h"
