//! Progress events of a comparison.

/// A step of a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CompareEvent<'a> {
    /// Before anything else.
    Started {
        /// How many scenes there are.
        scenes: usize,
        /// How many rows each scene has.
        rows_per_scene: usize,
    },
    /// A scene begins.
    Scene {
        /// Its name.
        name: &'a str,
        /// Its place, from 0.
        index: usize,
    },
    /// Truth advances; comes from any thread.
    Truth {
        /// Receivers traced so far.
        done: usize,
        /// Receivers to trace in all, repetitions included.
        total: usize,
    },
    /// A row begins.
    Row {
        /// The technique's name.
        technique: &'a str,
        /// Its settings.
        settings: &'a str,
        /// The backend's kind.
        backend: &'a str,
        /// Its place in the scene, from 0.
        index: usize,
    },
    /// A scene's figures are there.
    SceneDone {
        /// The figures.
        result: &'a super::SceneResult,
    },
    /// The report is being written.
    Writing,
}

/// Receives the events, from any thread.
pub type OnEvent<'a> = dyn Fn(CompareEvent<'_>) + Sync + 'a;
