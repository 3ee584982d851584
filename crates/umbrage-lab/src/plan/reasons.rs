//! Reasons in plain words, built from what was measured.

use super::{Bounds, Options, Setting, trial::Trial};
use crate::LabError;

/// What was measured of the scene itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Facts {}

impl Facts {
    pub(super) fn find(_trial: &mut Trial<'_>, _options: &Options) -> Result<Self, LabError> {
        Ok(Self {})
    }

    pub(super) fn reasons(&self, _: &Trial<'_>, _: &Bounds, _: Option<&Setting>) -> Vec<String> {
        Vec::new()
    }
}
