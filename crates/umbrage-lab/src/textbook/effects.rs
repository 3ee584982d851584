//! The one list of effects.

use super::effect::{Effect, Preset};
use umbrage_core::{
    Extents, Fit, Layout, Light, RasterBias, Scene,
    glam::{UVec2, Vec3},
};
use umbrage_scenes::TEXTBOOK_FIT;
use umbrage_techniques::{
    BeyondFar, Bias, Border, Hard, MapFilter as _, MapFormat, Midpoint, Pcf, PcfDithered, Pcss,
    ShadowMap, ShadowVolumes, TechniquePreset,
};

type Technique = TechniquePreset;

/// Reason for kernels that blur edges where truth has no penumbra.
const IDEAL_LIGHT: &str = "Under a light without extent, true edges are sharp, so every blurred pixel along an edge counts as \
                           an error. The blur replaces visible steps with greys, which the error counts.";

/// Returns all effects in reading order.
pub fn all() -> &'static [Effect] {
    ALL
}

/// Returns the textbooks' map: 1024 texels, fitted by hand from (-2, 4, -1), 10 m to each side,
/// near 1, far 7.5.
fn map(bias: Bias) -> ShadowMap {
    ShadowMap {
        size: 1024,
        fit: TEXTBOOK_FIT,
        bias,
        ..ShadowMap::default()
    }
}

/// Receiver-plane bias plus a constant that covers only the rounding of 32-bit floats.
const FOR_FLOATS: Bias = Bias {
    constant: 1e-6,
    ..Bias::RECEIVER_PLANE
};

/// Returns a map whose texels are large enough to be visible.
fn coarse(bias: Bias) -> ShadowMap {
    ShadowMap {
        size: 256,
        ..map(bias)
    }
}

/// Returns a map that ends within the image.
fn small_map(border: Border) -> ShadowMap {
    ShadowMap {
        fit: extents(|e| Extents {
            left: -1.2,
            right: 1.2,
            bottom: -1.2,
            top: 1.2,
            ..e
        }),
        border,
        ..map(Bias::SLOPE)
    }
}

/// Returns a map whose far plane cuts the floor.
fn short_map(beyond_far: BeyondFar) -> ShadowMap {
    ShadowMap {
        fit: extents(|e| Extents { far: 5.0, ..e }),
        beyond_far,
        ..map(Bias::SLOPE)
    }
}

fn extents(change: fn(Extents) -> Extents) -> Fit {
    match TEXTBOOK_FIT {
        Fit::Manual { eye, extents } => Fit::Manual {
            eye,
            extents: change(extents),
        },
        fit => fit,
    }
}

/// Returns a tightly fitted map, for scenes without a textbook's manual fit.
fn tight(size: u32, bias: Bias) -> ShadowMap {
    ShadowMap {
        size,
        bias,
        ..ShadowMap::default()
    }
}

/// Returns the textbooks' cube map around a point light: near 1, far 25.
fn room_map(size: u32, bias: Bias) -> ShadowMap {
    let fit = umbrage_scenes::find("textbook-room")
        .and_then(|e| e.fit)
        .unwrap_or_default();
    ShadowMap {
        fit,
        layout: Layout::Cube,
        ..tight(size, bias)
    }
}

fn hard(map: ShadowMap) -> Technique {
    TechniquePreset::from(Hard {}.on(map))
}

fn pcf(map: ShadowMap, radius: u32) -> Technique {
    TechniquePreset::from(Pcf::new(radius).on(map))
}

fn built_in(name: &str) -> Scene {
    umbrage_scenes::find(name)
        .map(|e| (e.build)())
        .unwrap_or_default()
}

/// Returns the scene with its cameras resized to the gallery's image size.
fn with_test_size(mut scene: Scene) -> Scene {
    scene
        .cameras
        .iter_mut()
        .for_each(|c| *c = c.with_size(UVec2::new(400, 300)));
    scene
}

fn cubes() -> Scene {
    with_test_size(built_in("cubes"))
}

/// Returns the cubes under a spot light at the position of the textbooks' sun map.
fn cubes_under_spot() -> Scene {
    let mut scene = cubes();
    let position = Vec3::new(-2.0, 4.0, -1.0);
    scene.lights = vec![Light::Spot {
        position,
        direction: -position,
        inner: 0.7,
        outer: 0.78,
        radius: 0.0,
    }];
    scene
}

fn figure() -> Scene {
    with_test_size(built_in("figure"))
}

fn teapot() -> Scene {
    with_test_size(built_in("teapot-lamp"))
}

fn room() -> Scene {
    with_test_size(built_in("textbook-room"))
}

fn flat() -> Scene {
    with_test_size(built_in("flat-receivers"))
}

fn wall() -> Scene {
    with_test_size(built_in("textbook-wall"))
}

/// Returns the wall without its normal map.
fn smooth_wall() -> Scene {
    let mut scene = wall();
    scene.materials.iter_mut().for_each(|m| m.normal_map = None);
    scene
}

fn relief() -> Scene {
    with_test_size(built_in("displaced-wall"))
}

fn relief_of_the_camera_alone() -> Scene {
    with_test_size(built_in("relief-without-depth-pass"))
}

fn far_range() -> Scene {
    with_test_size(built_in("far-range"))
}

fn plate() -> Scene {
    with_test_size(built_in("thin-plate"))
}

const fn cubes_with(label: &'static str, technique: fn() -> Technique) -> Preset {
    Preset {
        label,
        scene: cubes,
        technique,
    }
}

const ALL: &[Effect] = &[
    Effect {
        name: "acne",
        title: "Shadow acne, and slope-scaled bias",
        text: "One texel stores one depth for a whole patch of a sloping surface, so half of the patch is behind that depth: \
               stripes. Subtracting max(.05 (1 - n.l), .005) from the receiver's depth removes them.",
        fault: cubes_with("no bias", || hard(map(Bias::NONE))),
        cure: cubes_with("bias .05 / .005", || hard(map(Bias::SLOPE))),
        worse: None,
    },
    Effect {
        name: "peter-panning",
        title: "Peter-panning, and culling front faces",
        text: "A bias of .05 of the depth range detaches every shadow from its caster: a plate 2 mm thick seems to float. With \
               front faces culled from the map, the closed plate needs no bias.",
        fault: Preset {
            label: "constant bias .05",
            scene: plate,
            technique: || {
                hard(tight(
                    1024,
                    Bias {
                        constant: 0.05,
                        ..Bias::NONE
                    },
                ))
            },
        },
        cure: Preset {
            label: "front faces culled",
            scene: plate,
            technique: || hard(tight(1024, Bias::FRONT_CULL)),
        },
        worse: None,
    },
    Effect {
        name: "polygon-offset",
        title: "Polygon offset",
        text: "The rasteriser itself can push casters away, each triangle by its own slope: glPolygonOffset(2, 4) adds 2 times \
               the slope and 4 steps of the depth format.",
        fault: cubes_with("no bias", || hard(map(Bias::NONE))),
        cure: cubes_with("polygon offset 2, 4", || {
            hard(map(Bias {
                raster: RasterBias {
                    constant: 4,
                    slope: 2.0,
                    clamp: 0.0,
                },
                ..Bias::NONE
            }))
        }),
        worse: None,
    },
    Effect {
        name: "border",
        title: "The dark border beyond the map",
        text: "A lookup outside the map returns what the sampler's address mode repeats. With the edge repeated, casters at the \
               edge cast endless bands; with a border of depth 1, everything outside the map is lit.",
        fault: cubes_with("edge repeated", || hard(small_map(Border::Clamp))),
        cure: cubes_with("lit border", || hard(small_map(Border::Lit))),
        worse: None,
    },
    Effect {
        name: "far-plane",
        title: "Darkness beyond the far plane",
        text: "Receivers beyond the light's far plane have a depth above 1, which no texel reaches: all are dark, unless the \
               lookup treats them as lit.",
        fault: cubes_with("compared", || hard(short_map(BeyondFar::Compared))),
        cure: cubes_with("lit", || hard(short_map(BeyondFar::Lit))),
        worse: None,
    },
    Effect {
        name: "jagged",
        title: "Jagged edges, and percentage-closer filtering",
        text: "One comparison per pixel shows the map's texels. The mean of 3x3 comparisons blurs the steps over three texels. \
               Its bias is three times as large, because it must prevent acne in all nine texels.",
        fault: cubes_with("one comparison", || hard(coarse(Bias::normal_offset(0.0)))),
        cure: cubes_with("3x3 comparisons", || {
            pcf(coarse(Bias::normal_offset(1.0)), 1)
        }),
        worse: Some(IDEAL_LIGHT),
    },
    Effect {
        name: "dithered",
        title: "Four dithered comparisons",
        text: "A quarter of the cost of 4x4 comparisons: each pixel uses four of the sixteen, and its neighbours use others.",
        fault: cubes_with("one comparison", || hard(coarse(Bias::normal_offset(0.0)))),
        cure: cubes_with("4 of 16, by the pixel's parity", || {
            TechniquePreset::from(PcfDithered {}.on(coarse(Bias::normal_offset(1.5))))
        }),
        worse: Some(IDEAL_LIGHT),
    },
    Effect {
        name: "perspective",
        title: "Orthographic and perspective light",
        text: "The sun's rays are parallel, so its map is orthographic. A spot light's rays diverge, so its map has perspective \
               and its shadows grow. The first map is fitted by hand, the second to the visible geometry.",
        fault: cubes_with("orthographic, by hand", || hard(map(Bias::SLOPE))),
        cure: Preset {
            label: "perspective, fitted",
            scene: cubes_under_spot,
            technique: || hard(tight(1024, Bias::ADAPTIVE)),
        },
        worse: Some(
            "Each light is compared with its own truth: the spot light's shadows are larger, so more pixels are on their edges, \
             where both maps err.",
        ),
    },
    Effect {
        name: "soft",
        title: "One penumbra everywhere, and percentage-closer soft shadows",
        text: "An area light casts shadows that are sharp where caster and receiver touch and soften with distance. A fixed \
               kernel has one width; PCSS first estimates the distance of the blockers.",
        fault: Preset {
            label: "5x5 comparisons",
            scene: teapot,
            technique: || pcf(tight(1024, Bias::ADAPTIVE), 2),
        },
        cure: Preset {
            label: "PCSS, 16 + 32 taps",
            scene: teapot,
            technique: || TechniquePreset::from(Pcss::default().on(tight(1024, Bias::ADAPTIVE))),
        },
        worse: None,
    },
    Effect {
        name: "point-light",
        title: "A point light in a room",
        text: "Six maps form a cube around a light inside the scene. They need bias like any other map.",
        fault: Preset {
            label: "cube, near 1, far 25, no bias",
            scene: room,
            technique: || hard(room_map(1024, Bias::NONE)),
        },
        cure: Preset {
            label: "cube, default bias",
            scene: room,
            technique: || hard(tight(1024, Bias::ADAPTIVE)),
        },
        worse: None,
    },
    Effect {
        name: "point-light-pcf",
        title: "A point light, filtered",
        text: "Each face of the cube is a little wider than 90 degrees, so a kernel never leaves its face and no seam shows.",
        fault: Preset {
            label: "one comparison",
            scene: room,
            technique: || hard(room_map(256, Bias::ADAPTIVE)),
        },
        cure: Preset {
            label: "3x3 comparisons",
            scene: room,
            technique: || pcf(room_map(256, Bias::ADAPTIVE), 1),
        },
        worse: Some(IDEAL_LIGHT),
    },
    Effect {
        name: "midpoint",
        title: "Midpoint maps",
        text: "Between the nearest surface and the second one there is a margin for rounding. Compared with the midpoint, closed \
               casters need no bias at all.",
        fault: Preset {
            label: "no bias",
            scene: figure,
            technique: || hard(tight(1024, Bias::NONE)),
        },
        cure: Preset {
            label: "midpoint, no bias",
            scene: figure,
            technique: || TechniquePreset::from(Midpoint { radius: 0 }.on(tight(1024, Bias::NONE))),
        },
        worse: None,
    },
    Effect {
        name: "sixteen-bits",
        title: "Sixteen bits of depth, and RGBA8 packing",
        text: "Over hundreds of metres 65,536 depths are few, and a bias meant for 32 bits is too small: quantised acne. Packed \
               into four 8-bit channels, all 24 bits of a float survive.",
        fault: Preset {
            label: "16 bit, receiver plane + 1e-6",
            scene: far_range,
            technique: || {
                hard(ShadowMap {
                    format: MapFormat::Depth16,
                    ..tight(1024, FOR_FLOATS)
                })
            },
        },
        cure: Preset {
            label: "RGBA8, receiver plane + 1e-6",
            scene: far_range,
            technique: || {
                hard(ShadowMap {
                    format: MapFormat::Rgba8,
                    ..tight(1024, FOR_FLOATS)
                })
            },
        },
        worse: None,
    },
    Effect {
        name: "contact",
        title: "Contact, and shadow volumes",
        text: "A plate 2 mm thick stands on a floor: the textbooks' bias opens a gap. Shadow volumes count crossings of exact \
               boundaries and have neither texels nor bias.",
        fault: Preset {
            label: "bias .05 / .005",
            scene: plate,
            technique: || hard(tight(1024, Bias::SLOPE)),
        },
        cure: Preset {
            label: "shadow volumes",
            scene: plate,
            technique: || TechniquePreset::from(ShadowVolumes::default()),
        },
        worse: None,
    },
    Effect {
        name: "planar",
        title: "Planar shadows",
        text: "On a flat receiver, one matrix flattens the casters, which are then drawn. Clipped at the light and at the plane, \
               they leave no anti-shadows.",
        fault: Preset {
            label: "one comparison",
            scene: flat,
            technique: || hard(tight(512, Bias::SLOPE)),
        },
        cure: Preset {
            label: "planar",
            scene: flat,
            technique: || TechniquePreset::from(umbrage_techniques::Planar::default()),
        },
        worse: None,
    },
    Effect {
        name: "normal-mapping",
        title: "Normal mapping",
        text: "A texture of normals changes the shading of a flat wall. Shadow lookups ignore it: their bias follows the \
               triangle's own normal, so the mask stays the same.",
        fault: Preset {
            label: "flat",
            scene: smooth_wall,
            technique: || pcf(tight(1024, Bias::ADAPTIVE), 1),
        },
        cure: Preset {
            label: "normal map",
            scene: wall,
            technique: || pcf(tight(1024, Bias::ADAPTIVE), 1),
        },
        worse: None,
    },
    Effect {
        name: "displacement",
        title: "Displacement mapping, in both passes",
        text: "A height map moves vertices along their normals. If only the camera pass draws the relief, bricks cast no shadow \
               into the joints; drawn into the depth map as well, they do.",
        fault: Preset {
            label: "camera pass only",
            scene: relief_of_the_camera_alone,
            technique: || pcf(tight(2048, Bias::ADAPTIVE), 1),
        },
        cure: Preset {
            label: "camera and light passes",
            scene: relief,
            technique: || pcf(tight(2048, Bias::ADAPTIVE), 1),
        },
        worse: Some(
            "Each half is compared with its own truth: the left one has bricks without shadows, the right one has hundreds of \
             small shadows, along whose edges the mask errs.",
        ),
    },
];
