//! Examples of each cause of error: scenes in which no other cause occurs.

use umbrage_core::metrics::Cause;
use umbrage_techniques::{Bias, Hard, MapFilter as _, SecondDepth, ShadowMap, TechniquePreset};

/// A scene and a technique whose whole error has one cause.
#[derive(Clone, Debug)]
pub struct CauseExample {
    /// The built-in scene's name.
    pub scene: &'static str,
    /// The technique.
    pub technique: TechniquePreset,
    /// Cause of its error.
    pub cause: Cause,
}

/// Returns one example for each cause.
pub fn faults() -> [CauseExample; 5] {
    [
        CauseExample {
            scene: "cause-acne",
            technique: hard(512, Bias::NONE),
            cause: Cause::Acne,
        },
        CauseExample {
            scene: "cause-gap",
            technique: hard(2048, FAR_TOO_MUCH),
            cause: Cause::Gap,
        },
        CauseExample {
            scene: "cause-leak",
            technique: TechniquePreset::from(
                SecondDepth { radius: 0 }.on(map(512, Bias::FRONT_CULL)),
            ),
            cause: Cause::Leak,
        },
        CauseExample {
            scene: "cause-edge",
            technique: hard(64, Bias::ADAPTIVE),
            cause: Cause::Edge,
        },
        CauseExample {
            scene: "cause-penumbra",
            technique: hard(1024, Bias::ADAPTIVE),
            cause: Cause::Penumbra,
        },
    ]
}

/// A constant bias of a fiftieth of the depth range, as in typical first attempts.
const FAR_TOO_MUCH: Bias = Bias {
    constant: 0.02,
    ..Bias::NONE
};

fn hard(size: u32, bias: Bias) -> TechniquePreset {
    TechniquePreset::from(Hard {}.on(map(size, bias)))
}

fn map(size: u32, bias: Bias) -> ShadowMap {
    ShadowMap {
        size,
        bias,
        ..ShadowMap::default()
    }
}
