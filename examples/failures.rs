//! Shadow artefacts next to their fixes, on built-in scenes: the content of `docs/failures.md`.

use crate::{judge::JudgedScene, sheet::Sheet, variance::Variance};
use anyhow::Result;
use std::sync::Arc;
use umbrage::{
    Cascades, Extents, Fit, Layout, ShadowTechnique,
    cpu::Cpu,
    glam::{UVec2, Vec3},
    metrics::Errors,
    techniques::{
        Bias, Exact, Hard, MapFilter as _, Pcf, Pcss, SecondDepth, ShadowMap, Soft, Traced,
    },
};
use umbrage_lab::output::png;
use umbrage_plan::truth::TruthOptions;

/// Size of the images, pixels.
pub const SIZE: UVec2 = UVec2::new(320, 240);

/// An artefact and its fix.
pub struct FailureExample {
    /// Name of its images.
    pub name: &'static str,
    /// Heading on the page.
    pub title: &'static str,
    /// A built-in scene.
    pub scene: &'static str,
    /// Title of the stability matrix' row that detects the artefact.
    pub row: &'static str,
    /// Settings with the artefact.
    pub fault: FailureSide,
    /// Settings without it.
    pub cure: FailureSide,
}

/// A technique with its settings.
pub struct FailureSide {
    /// Description of the settings.
    pub words: &'static str,
    /// Returns the technique.
    pub technique: fn() -> Arc<dyn ShadowTechnique>,
}

const fn side(words: &'static str, technique: fn() -> Arc<dyn ShadowTechnique>) -> FailureSide {
    FailureSide { words, technique }
}

fn hard(map: ShadowMap) -> Arc<dyn ShadowTechnique> {
    Arc::new(Hard {}.on(map))
}

fn pcf(map: ShadowMap, radius: u32) -> Arc<dyn ShadowTechnique> {
    Arc::new(Pcf::new(radius).on(map))
}

fn second_depth(size: u32) -> Arc<dyn ShadowTechnique> {
    Arc::new(SecondDepth { radius: 0 }.on(map(size, Bias::FRONT_CULL)))
}

fn exact() -> Arc<dyn ShadowTechnique> {
    Arc::new(Exact::default())
}

fn soft() -> Arc<dyn ShadowTechnique> {
    Arc::new(Soft::default())
}

/// Returns a map with this bias.
fn map(size: u32, bias: Bias) -> ShadowMap {
    ShadowMap {
        size,
        bias,
        ..ShadowMap::default()
    }
}

/// A bias of a fiftieth of the depth range.
const FAR_TOO_MUCH: Bias = Bias {
    constant: 0.02,
    ..Bias::NONE
};

/// Returns four layers, each with a fourth of the texels of a map of this side.
fn cascades(size: u32) -> ShadowMap {
    let four = Cascades {
        nearest: 4.0,
        ..Cascades::default()
    };
    ShadowMap {
        layout: Layout::Cascades(four),
        ..map(size / 2, Bias::ADAPTIVE)
    }
}

/// Returns a map that begins at the image's border, as if it were only fitted to the camera's view.
fn around_the_picture() -> ShadowMap {
    let extents = Extents {
        left: -10.0,
        right: 10.0,
        bottom: -10.0,
        top: 10.0,
        near: 0.1,
        far: 30.0,
    };
    ShadowMap {
        fit: Fit::Manual {
            eye: Vec3::new(-8.0, 5.2, -0.64),
            extents,
        },
        ..map(1024, Bias::ADAPTIVE)
    }
}

/// Returns all artefacts, in the page's order.
pub fn failures() -> &'static [FailureExample] {
    ALL
}

const ALL: &[FailureExample] = &[
    FailureExample {
        name: "acne",
        title: "Acne",
        scene: "low-sun-5",
        row: "low sun",
        fault: side("`hard`, no bias", || hard(map(1024, Bias::NONE))),
        cure: side("`hard`, the default bias", || {
            hard(map(1024, Bias::ADAPTIVE))
        }),
    },
    FailureExample {
        name: "wide-kernel",
        title: "A bias too small for a wide kernel",
        scene: "low-sun-10",
        row: "low sun",
        fault: side("`pcf` 7x7, a bias for one comparison", || {
            pcf(map(1024, Bias::NORMAL_OFFSET), 3)
        }),
        cure: side("`pcf` 7x7, the default bias", || {
            pcf(map(1024, Bias::ADAPTIVE), 3)
        }),
    },
    FailureExample {
        name: "peter-panning",
        title: "Peter-panning",
        scene: "thin-plate",
        row: "thin contact",
        fault: side("`hard`, a constant bias of .02", || {
            hard(map(1024, FAR_TOO_MUCH))
        }),
        cure: side("`hard`, the default bias", || {
            hard(map(1024, Bias::ADAPTIVE))
        }),
    },
    FailureExample {
        name: "leak",
        title: "Light that leaks in",
        scene: "broken-meshes",
        row: "broken meshes",
        fault: side("`second_depth`", || second_depth(512)),
        cure: side("`hard`, the default bias", || {
            hard(map(512, Bias::ADAPTIVE))
        }),
    },
    FailureExample {
        name: "bleeding",
        title: "Light that bleeds through",
        scene: "hovering-feet",
        row: "near contact",
        fault: side("variance shadow maps, 512", || {
            Arc::new(Variance {
                map: map(512, Bias::ADAPTIVE),
                ..Variance::default()
            })
        }),
        cure: side("`pcf` 3x3, 512, the default bias", || {
            pcf(map(512, Bias::ADAPTIVE), 1)
        }),
    },
    FailureExample {
        name: "corner",
        title: "Lines along corners",
        scene: "room-corner",
        row: "room corners",
        fault: side("`pcf` 7x7, the default bias", || {
            pcf(map(512, Bias::ADAPTIVE), 3)
        }),
        cure: side("`exact`", exact),
    },
    FailureExample {
        name: "open-shells",
        title: "Casters without a far side",
        scene: "open-shells",
        row: "open shells",
        fault: side("`second_depth`", || second_depth(1024)),
        cure: side("`hard`, the default bias", || {
            hard(map(1024, Bias::ADAPTIVE))
        }),
    },
    FailureExample {
        name: "aliasing",
        title: "Aliasing",
        scene: "street",
        row: "landscape",
        fault: side("`hard`, one map of 1024", || {
            hard(map(1024, Bias::ADAPTIVE))
        }),
        cure: side("`hard`, four cascades of 512", || hard(cascades(1024))),
    },
    FailureExample {
        name: "fine-detail",
        title: "Fine detail",
        scene: "fence",
        row: "fine detail",
        fault: side("`hard`, a map of 512", || hard(map(512, Bias::ADAPTIVE))),
        cure: side("`exact`", exact),
    },
    FailureExample {
        name: "out-of-view",
        title: "Casters out of view",
        scene: "tower-out-of-view",
        row: "caster out of view",
        fault: side("a map around what is seen, by hand", || {
            hard(around_the_picture())
        }),
        cure: side("a map that is fitted to the casters", || {
            hard(map(1024, Bias::ADAPTIVE))
        }),
    },
    FailureExample {
        name: "one-width",
        title: "Penumbrae of one width",
        scene: "rising-boxes",
        row: "rising heights",
        fault: side("`pcf` 7x7", || pcf(map(1024, Bias::ADAPTIVE), 3)),
        cure: side("`pcss`, 16 + 32 taps", || {
            Arc::new(Pcss::default().on(map(1024, Bias::ADAPTIVE)))
        }),
    },
    FailureExample {
        name: "two-blockers",
        title: "Two blockers",
        scene: "two-blockers",
        row: "two blockers",
        fault: side("`pcss`, 16 + 32 taps", || {
            Arc::new(Pcss::default().on(map(1024, Bias::ADAPTIVE)))
        }),
        cure: side("`soft`", soft),
    },
    FailureExample {
        name: "noise",
        title: "Noise",
        scene: "canopy",
        row: "canopy",
        fault: side("`traced`, 4 rays", || Arc::new(Traced { samples: 4 })),
        cure: side("`soft`", soft),
    },
];

/// Both sides, compared with the reference.
pub struct RenderedFailure {
    /// Errors of a mask without shadows.
    pub no_shadow: Errors,
    /// Errors of the artefact.
    pub fault: Errors,
    /// Errors of the fix.
    pub cure: Errors,
    /// The masks of artefact and fix; below them, their errors.
    pub images: Sheet,
}

impl FailureExample {
    /// Renders both sides on the CPU in images of this size.
    ///
    /// # Errors
    /// Returns an error if the scene or a setting is invalid.
    pub fn render(&self, size: UVec2) -> Result<RenderedFailure> {
        let judged = JudgedScene::by_argument(self.scene, Some(size), &TruthOptions::default())?;
        let render = |side: &FailureSide| {
            judged.judge(judged.render(&mut Cpu::new(), &*(side.technique)())?.mask)
        };
        let sides = [render(&self.fault)?, render(&self.cure)?];
        let mut images = Sheet::new(2);
        for side in &sides {
            images.push_png(&png::mask(size, &side.mask, &side.pixels)?)?;
        }
        for side in &sides {
            let visibility = &judged.truth.visibility;
            images.push_png(&png::error(size, &side.mask, visibility, &side.pixels)?)?;
        }
        let [fault, cure] = sides.map(|side| side.errors);
        let lit = vec![1.0; judged.truth.visibility.len()];
        Ok(RenderedFailure {
            no_shadow: judged.judge(lit)?.errors,
            fault,
            cure,
            images,
        })
    }
}
