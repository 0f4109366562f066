// Whether a surface may have two roughnesses: each then has mirrors of its own, which costs.
#ifndef LEADR_MIXED
#define LEADR_MIXED

layout(constant_id = 49) const bool MIXED_ROUGHNESS = false;

#endif
