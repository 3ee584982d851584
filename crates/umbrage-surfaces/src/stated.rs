//! What an answer states about its own accuracy.

use std::{fmt, hash::Hasher as _};
use twox_hash::XxHash3_64;

/// The number of undecided rows that are listed.
const LISTED: usize = 1000;

/// Accuracy and provenance of an answer. Each answer has one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stated {
    /// Number of answers (pairs of a row and a sun) that may change if a coordinate moves by the
    /// margin: an edge passes that close, or a facet is edge-on to the sun within it.
    pub undecided: u64,
    /// The first undecided answers, at most 1,000: (index of the sun, row).
    pub undecided_rows: Vec<(u32, u32)>,
    /// All other answers are right for coordinates that differ from the given ones by at most this
    /// length, metres. Facets that are closer to each other than this touch.
    pub margin_m: f64,
    /// Greatest relative difference over the suns: the sum of lit projected areas over the area of
    /// the silhouette, minus 1. `None` unless [`Options::certify`](crate::Options::certify) is set.
    pub identity: Option<f64>,
    /// Greatest distance between two samples in time, seconds; `None` if nothing was sampled.
    pub step_s: Option<f64>,
    /// Greatest error of each time at which the sun appears or disappears between two samples that
    /// differ, seconds; `None` if there are no times.
    pub bisected_s: Option<f64>,
    /// Radius of the Sun's disc, degrees; `None` for its centre.
    pub disc_degrees: Option<f64>,
    /// Greatest error of a share of the disc, or of an area averaged over it, 0..=1.
    pub disc_error: Option<f64>,
    /// True if the sun's directions include refraction, as the caller states.
    pub refraction: Option<bool>,
    /// Hash (XXH3, 64 bits) of all numbers of the answer, in order: the same on any number of
    /// threads, from Rust and from Python.
    pub hash: u64,
}

impl Stated {
    /// Adds undecided answers in any order.
    pub(crate) fn add_undecided(&mut self, answers: impl IntoIterator<Item = (u32, u32)>) {
        for answer in answers {
            self.undecided += 1;
            self.undecided_rows.push(answer);
            if self.undecided_rows.len() == 2 * LISTED {
                self.keep_listed();
            }
        }
    }

    /// Ends the list of undecided answers.
    pub(crate) fn keep_listed(&mut self) {
        self.undecided_rows.sort_unstable();
        self.undecided_rows.truncate(LISTED);
    }
}

/// Formats as `3 undecided; margin 3.8e-10 m; hash 0123456789abcdef`, with further parts if there
/// are any.
impl fmt::Display for Stated {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} undecided; margin {:.1e} m",
            self.undecided, self.margin_m
        )?;
        if let Some(identity) = self.identity {
            write!(f, "; identity {identity:.1e}")?;
        }
        if let Some(step) = self.step_s {
            write!(f, "; step {step} s")?;
        }
        if let Some(bisected) = self.bisected_s {
            write!(f, "; bisected to {bisected} s")?;
        }
        match self.disc_degrees {
            Some(radius) => write!(f, "; disc of {radius} degrees radius")?,
            None => write!(f, "; centre of the sun")?,
        }
        if let Some(error) = self.disc_error {
            write!(f, "; error over the disc {error:.1e}")?;
        }
        match self.refraction {
            Some(true) => write!(f, "; with refraction")?,
            Some(false) => write!(f, "; without refraction")?,
            None => (),
        }
        write!(f, "; hash {:016x}", self.hash)
    }
}

/// The hash of an answer under construction.
pub(crate) struct AnswerHash(XxHash3_64);

impl AnswerHash {
    pub(crate) fn new() -> Self {
        Self(XxHash3_64::with_seed(0))
    }

    /// Adds the bits of a number, least byte first.
    pub(crate) fn add(&mut self, number: f64) {
        self.add_bits(number.to_bits());
    }

    /// Adds 64 bits, least byte first.
    pub(crate) fn add_bits(&mut self, bits: u64) {
        self.0.write(&bits.to_le_bytes());
    }

    pub(crate) fn finish(&self) -> u64 {
        self.0.finish()
    }
}
