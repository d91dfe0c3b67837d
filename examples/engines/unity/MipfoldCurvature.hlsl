// mipfold in Unity: smoothness after the curvature of the mesh, for Shader Graph.
//
// For:         Shader Graph 17 (Unity 6), URP and HDRP.
// Include:     mipfold kernels geometric_aa_screen --lang hlsl --bundle > geometric_aa_screen.hlsl
// Put:         this file and the include file into one folder below Assets. In the graph: a Custom Function node, Type
//              File, Source this file, Name MipfoldCurvature; inputs Smoothness (Float) and Normal (Vector 3), in this
//              order, output Filtered (Float). Connect the smoothness of the map and a Normal Vector node (any space),
//              and Filtered with Smoothness of the Fragment block.
// Turn off:    HDRP's Geometric Specular AA of the material, or it counts twice.
// Unverified:  never run in Unity; passes without derivatives, as ray tracing. The tests compile it by glslang and compare
//              what it computes with the helper's twin.
#ifndef MIPFOLD_CURVATURE_INCLUDED
#define MIPFOLD_CURVATURE_INCLUDED

#include "geometric_aa_screen.hlsl"

void MipfoldCurvature_float(float Smoothness, float3 Normal, out float Filtered)
{
    float roughness = 1.0 - Smoothness;
    float alpha = roughness * roughness;
    float alpha2 = mf_aa_screen_normal(alpha * alpha, normalize(Normal), MF_SIGMA2_PEAK, MF_MOST_ADDED);
    Filtered = 1.0 - sqrt(sqrt(alpha2));
}

// In floats all the same: a half has few digits left for alpha^2 of a smooth surface.
void MipfoldCurvature_half(half Smoothness, half3 Normal, out half Filtered)
{
    float filtered;
    MipfoldCurvature_float(float(Smoothness), float3(Normal), filtered);
    Filtered = half(filtered);
}

#endif
