//! Cascaded shadow maps: how the camera's view is cut into slices, each with a layer of its own.
//!
//! Of one map for all that a camera sees, the texels are far too large near the camera and far too
//! small beyond. So the view is cut across into slices, each slice gets a map (Engel 2006,
//! "Cascaded shadow maps"; Zhang, Sun, Xu and Lun 2006, "Parallel-split shadow maps for large-scale
//! virtual environments"), and a receiver is looked up in the finest map that holds it.

use crate::invalid::{self, Invalid};

/// Most slices.
pub const MAX_CASCADES: usize = 8;
/// A held slice shrinks once it is larger than what was found by this factor.
const SHRINK_AT: f32 = 1.2;

/// How a camera's view is cut into slices: see [`Layout::Cascades`](crate::Layout::Cascades).
///
/// Slices are cut along the camera's view, and their maps overlap. A lookup takes the first map,
/// from the camera on, that holds the receiver with all that the kernel reaches; the last one where
/// none does.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Cascades {
    /// How many slices, 1 to [`MAX_CASCADES`].
    pub count: u32,
    /// Where one slice ends and the next begins.
    pub split: Split,
    /// Metres along the camera's view: slices are cut as if the camera's near plane were at least
    /// there, and the first reaches to the camera all the same. A camera's near plane is mostly far
    /// nearer than what it looks at.
    pub nearest: f32,
    /// Over how many texels, from where the kernel would leave a map inwards, its answers blend
    /// into those of the next map. 0 switches blending off: then only one map is looked up, and the
    /// change of texel size may show as a line.
    pub blend: f32,
}

impl Default for Cascades {
    fn default() -> Self {
        Self {
            count: 4,
            split: Split::Log,
            nearest: 4.0,
            blend: 0.0,
        }
    }
}

/// Where a camera's view is cut into slices.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum Split {
    /// Each slice ends at the same multiple of the distance at which it begins: then a texel of
    /// each map spans as many pixels (Lloyd, Tuft, Yoon and Manocha 2006, "Warping and partitioning
    /// for low error shadow maps").
    #[default]
    Log,
    /// Between [`Split::Log`] and slices of equal length (Zhang et al. 2006).
    Practical {
        /// Share of the logarithmic split, 0..=1.
        lambda: f32,
    },
    /// By what is seen: where the texels' size in pixels, over all receivers that face the light,
    /// is least in the mean. It is [`Split::Log`] where receivers aren't known. After Lauritzen,
    /// Salvi and Lefohn 2010, "Sample distribution shadow maps", who cut the range of seen depths;
    /// here the cuts themselves follow the receivers, too.
    ///
    /// Slices follow the camera, and texels change size with them. A program that holds them for
    /// many frames asks [`Fit::slice_ends`](crate::Fit::slice_ends) for those of a frame, makes
    /// [`SliceEnds::held`] of them, and gives these as [`Split::Given`].
    Receivers,
    /// These ends.
    Given(SliceEnds),
}

/// Where slices end, metres along the camera's view, from the nearest on. None ends before the one
/// before it; slices that end where they begin are empty.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "Vec<f32>", into = "Vec<f32>")
)]
pub struct SliceEnds {
    count: usize,
    /// Those after the first `count` are 0.
    ends: [f32; MAX_CASCADES],
}

impl SliceEnds {
    /// Returns these ends.
    ///
    /// # Errors
    /// Errors unless they are 1 to [`MAX_CASCADES`] positive numbers of which none is less than the
    /// one before.
    pub fn new(ends: &[f32]) -> Result<Self, Invalid> {
        if ends.is_empty() || ends.len() > MAX_CASCADES {
            return Err(Invalid::new(
                "slices' ends",
                format!("are {}", ends.len()),
                format!("give 1 to {MAX_CASCADES}, one for each slice"),
            ));
        }
        for &end in ends {
            invalid::positive("slice's end", end)?;
        }
        for pair in ends.windows(2) {
            if pair[1] < pair[0] {
                return Err(Invalid::new(
                    "slices' ends",
                    format!("go from {} back to {}", pair[0], pair[1]),
                    "give them in rising order",
                ));
            }
        }
        let mut all = [0.0; MAX_CASCADES];
        all[..ends.len()].copy_from_slice(ends);
        Ok(Self {
            count: ends.len(),
            ends: all,
        })
    }

    /// Returns ends of which a search found these, at most [`MAX_CASCADES`] and at least one:
    /// positive and rising, whatever was found.
    pub(crate) fn of_found(found: &[f64]) -> Self {
        let mut ends = [0.0; MAX_CASCADES];
        let mut last = f32::MIN_POSITIVE;
        for (end, &found) in ends.iter_mut().zip(found) {
            last = last.max((found as f32).min(f32::MAX));
            *end = last;
        }
        Self {
            count: found.len().min(MAX_CASCADES),
            ends,
        }
    }

    /// Returns the ends, metres along the camera's view.
    pub fn as_slice(&self) -> &[f32] {
        &self.ends[..self.count]
    }

    /// Returns what to hold in a frame for which `self` was found, where `before` was held in the
    /// frame before: an end grows at once, so that all that is seen stays in its slice, and shrinks
    /// only once it is too large by a fifth. If the number of slices changed, what was found.
    ///
    /// Texels change size where an end does, and shadows shimmer in that frame.
    #[must_use]
    pub fn held(&self, before: &Self) -> Self {
        if self.count != before.count {
            return *self;
        }
        let mut held = *self;
        let mut last = 0.0_f32;
        for (end, &end_before) in held.ends[..held.count].iter_mut().zip(&before.ends) {
            let stays = end_before >= *end && end_before <= *end * SHRINK_AT;
            if stays {
                *end = end_before;
            }
            // The one before may stay where this one shrinks.
            *end = end.max(last);
            last = *end;
        }
        held
    }
}

impl TryFrom<Vec<f32>> for SliceEnds {
    type Error = Invalid;

    fn try_from(ends: Vec<f32>) -> Result<Self, Invalid> {
        Self::new(&ends)
    }
}

impl From<SliceEnds> for Vec<f32> {
    fn from(ends: SliceEnds) -> Self {
        ends.as_slice().to_vec()
    }
}

impl Cascades {
    /// Returns a few words for tables.
    pub fn label(&self) -> String {
        let slices = if self.count == 1 {
            "1 cascade".to_owned()
        } else {
            format!("{} cascades", self.count)
        };
        let split = match self.split {
            Split::Log => format!("log from {} m", self.nearest),
            Split::Practical { lambda } => format!("practical {lambda} from {} m", self.nearest),
            Split::Receivers => "by receivers".to_owned(),
            Split::Given(ends) => {
                let ends: Vec<String> = ends.as_slice().iter().map(f32::to_string).collect();
                format!("to {} m", ends.join(", "))
            }
        };
        let blend = if self.blend > 0.0 {
            format!(" blend {}", self.blend)
        } else {
            String::new()
        };
        format!("{slices} {split}{blend}")
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// Errors with the first fault found: a count or a share out of range, a negative length, ends
    /// that are more or fewer than the slices.
    pub fn validate(&self) -> Result<(), Invalid> {
        if self.count == 0 || self.count as usize > MAX_CASCADES {
            return Err(Invalid::new(
                "cascades",
                format!("are {}", self.count),
                format!("use 1 to {MAX_CASCADES}"),
            ));
        }
        invalid::not_negative("cascades' nearest distance", self.nearest)?;
        invalid::not_negative("cascades' blend", self.blend)?;
        match self.split {
            Split::Log | Split::Receivers => Ok(()),
            Split::Practical { lambda } => {
                invalid::finite("practical split's lambda", &[lambda])?;
                if (0.0..=1.0).contains(&lambda) {
                    return Ok(());
                }
                Err(Invalid::new(
                    "practical split's lambda",
                    format!("is {lambda}"),
                    "use 0 (slices of equal length) to 1 (logarithmic)",
                ))
            }
            Split::Given(ends) if ends.count == self.count as usize => Ok(()),
            Split::Given(ends) => Err(Invalid::new(
                "cascades",
                format!("are {}, with {} given ends", self.count, ends.count),
                "give an end for each",
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ends(ends: &[f32]) -> SliceEnds {
        SliceEnds::new(ends).expect("rising")
    }

    #[test]
    fn ends_grow_at_once_and_shrink_late() {
        let before = ends(&[4.0, 20.0, 100.0]);
        assert_eq!(
            ends(&[5.0, 19.0, 70.0]).held(&before),
            ends(&[5.0, 20.0, 70.0])
        );
        // Where nothing moves much, nothing moves.
        assert_eq!(ends(&[3.9, 18.0, 90.0]).held(&before), before);
        assert_eq!(ends(&[3.9, 18.0]).held(&before), ends(&[3.9, 18.0]));
    }

    #[test]
    fn held_ends_still_rise() {
        let before = ends(&[100.0, 200.0]);
        // The first stays at 100, and the second shrinks, but not below it.
        assert_eq!(ends(&[90.0, 95.0]).held(&before), ends(&[100.0, 100.0]));
    }

    #[test]
    fn bad_numbers_are_refused() {
        let good = Cascades::default();
        assert_eq!(good.validate(), Ok(()));
        let bad = [
            Cascades { count: 0, ..good },
            Cascades { count: 9, ..good },
            Cascades {
                nearest: -1.0,
                ..good
            },
            Cascades {
                blend: f32::NAN,
                ..good
            },
            Cascades {
                split: Split::Practical { lambda: 1.5 },
                ..good
            },
            Cascades {
                split: Split::Given(ends(&[1.0, 2.0])),
                ..good
            },
        ];
        for cascades in bad {
            let error = cascades.validate().expect_err("bad").to_string();
            assert!(error.contains("use ") || error.contains("give "), "{error}");
        }
        for bad in [&[][..], &[2.0, 1.0], &[0.0], &[f32::INFINITY], &[1.0; 9]] {
            assert!(SliceEnds::new(bad).is_err(), "{bad:?}");
        }
    }
}
