// Moments of maps without mipmaps. Twin of `MomentLookups` in look_up.rs.

fn filtered_moments(l: ShadowCoord, r: Receiver) -> FilteredMoments {
    return FilteredMoments(blended_moments(l.texel, l.layer), 0.0);
}
