/// Rays through Embree 3 and 4, which take a query's context and filter in different ways.
#pragma once
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace inhabit {

#if RTC_VERSION_MAJOR >= 4

using RayContext = RTCRayQueryContext;
constexpr RTCSceneFlags kFilteredRays = RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;

inline void first_hit(RTCScene scene, RTCRayHit& ray) { rtcIntersect1(scene, &ray); }

/// `filter` sees every face the ray meets, with `context` in its arguments; what it calls invalid the ray goes through.
inline void every_hit(RTCScene scene, RTCRayHit& ray, RayContext& context, RTCFilterFunctionN filter) {
  rtcInitRayQueryContext(&context);
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
  arguments.context = &context;
  arguments.filter = filter;
  rtcIntersect1(scene, &ray, &arguments);
}

#else

using RayContext = RTCIntersectContext;
constexpr RTCSceneFlags kFilteredRays = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;

inline void every_hit(RTCScene scene, RTCRayHit& ray, RayContext& context, RTCFilterFunctionN filter) {
  rtcInitIntersectContext(&context);
  context.filter = filter;
  rtcIntersect1(scene, &context, &ray);
}

inline void first_hit(RTCScene scene, RTCRayHit& ray) {
  RayContext context;
  every_hit(scene, ray, context, nullptr);
}

#endif

}  // namespace inhabit
