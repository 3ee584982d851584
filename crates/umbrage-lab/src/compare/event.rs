//! Progress events of a comparison.

/// A step of a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CompareEvent<'a> {
    /// The comparison begins.
    Started {
        /// Number of scenes.
        scenes: usize,
        /// Total work: pixels times rows, summed over the scenes.
        work: u64,
    },
    /// A scene begins.
    Scene {
        /// The scene's name.
        name: &'a str,
        /// The scene's index, from 0.
        index: usize,
        /// Number of its rows.
        rows: usize,
        /// Share of the total work.
        work: u64,
    },
    /// Tracing of truth advances. May come from any thread.
    Truth {
        /// Receivers traced so far.
        done: usize,
        /// Receivers to trace in total, repetitions included.
        total: usize,
    },
    /// A row begins.
    Row {
        /// The technique's name.
        technique: &'a str,
        /// Settings of the technique.
        settings: &'a str,
        /// The backend's kind.
        backend: &'a str,
        /// The row's index in the scene, from 0.
        index: usize,
    },
    /// A scene is complete.
    SceneDone {
        /// The figures.
        result: &'a super::result::SceneResult,
    },
    /// The report is being written.
    Writing,
}

/// A callback for events. May be called from any thread.
pub type OnEvent<'a> = dyn Fn(CompareEvent<'_>) + Sync + 'a;
