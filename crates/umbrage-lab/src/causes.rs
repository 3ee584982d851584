//! What each cause of error looks like: scenes in which nothing else can be wrong.

use std::sync::Arc;
use umbrage_core::{ShadowTechnique, metrics::Cause};
use umbrage_techniques::{Bias, Hard, SecondDepth, ShadowMap};

/// A scene, a technique that is wrong there in one way, and that way.
#[derive(Clone, Debug)]
pub struct CauseExample {
    /// The built-in scene's name.
    pub scene: &'static str,
    /// What is played.
    pub technique: Arc<dyn ShadowTechnique>,
    /// What its whole error comes from.
    pub cause: Cause,
}

/// One fault a cause.
pub fn faults() -> [CauseExample; 5] {
    let map = |size, bias| ShadowMap {
        size,
        bias,
        ..ShadowMap::default()
    };
    let hard = |size, bias| {
        Arc::new(Hard {
            map: map(size, bias),
        })
    };
    [
        CauseExample {
            scene: "cause-acne",
            technique: hard(512, Bias::NONE),
            cause: Cause::Acne,
        },
        // A fiftieth of the depth range: a bare constant, such as first attempts use.
        CauseExample {
            scene: "cause-gap",
            technique: hard(
                2048,
                Bias {
                    constant: 0.02,
                    ..Bias::NONE
                },
            ),
            cause: Cause::Gap,
        },
        CauseExample {
            scene: "cause-leak",
            technique: Arc::new(SecondDepth {
                map: map(512, Bias::FRONT_CULL),
                radius: 0,
            }),
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
