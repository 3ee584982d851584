//! Progress events of a comparison.

/// A step of a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CompareEvent<'a> {
    /// Before anything else.
    Started {
        /// How many scenes there are.
        scenes: usize,
        /// How much work there is in all: pixels of images times rows, summed over the scenes.
        work: u64,
    },
    /// A scene begins.
    Scene {
        /// Its name.
        name: &'a str,
        /// Its place, from 0.
        index: usize,
        /// How many rows it has.
        rows: usize,
        /// Its part of the work.
        work: u64,
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
        result: &'a super::result::SceneResult,
    },
    /// The report is being written.
    Writing,
}

/// Receives the events, from any thread.
pub type OnEvent<'a> = dyn Fn(CompareEvent<'_>) + Sync + 'a;
