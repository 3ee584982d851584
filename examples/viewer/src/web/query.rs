//! Initial settings in the page's address:
//! `?scene=cubes&left=hard&right=exact&split=0.5&over=error`.

use crate::{
    bookmarks,
    measure::pictures::Picture,
    settings::{FirstShown, Start},
};
use umbrage::{scenes, techniques};
use web_sys::UrlSearchParams;

/// The keys, for messages.
const KEYS: &str = "scene, failure, left, right, split (0 to 1, or `left` or `right`) and over (nothing, error, truth, mask, \
                    texels, cascades or lists)";

/// Contents of the address.
#[derive(Default)]
pub(super) struct Query {
    pub start: Start,
    pub first_shown: FirstShown,
}

impl Query {
    /// Reads the page's address. A message lists invalid parts.
    pub(super) fn of_page() -> Self {
        let address = web_sys::window().and_then(|window| window.location().search().ok());
        let mut out = Self::default();
        let Some(parameters) = address
            .filter(|text| !text.is_empty())
            .and_then(|text| UrlSearchParams::new_with_str(&text).ok())
        else {
            return out;
        };
        // Ignore saved settings, so that a link is the same for everybody.
        out.start.is_fresh = true;
        let mut faults = Vec::new();
        for pair in parameters.entries().into_iter().flatten() {
            let pair: js_sys::Array = pair.into();
            let [Some(key), Some(value)] = [0, 1].map(|i| pair.get(i).as_string()) else {
                continue;
            };
            if let Err(fault) = out.take(&key, value) {
                faults.push(fault);
            }
        }
        if !faults.is_empty() {
            out.start.message = Some(format!("In this page's address: {}.", faults.join("; ")));
        }
        out
    }

    fn take(&mut self, key: &str, value: String) -> Result<(), String> {
        let unknown = |what: &str| Err(format!("there is no {what} `{value}`"));
        match key {
            "scene" => match scenes::find(&value) {
                Some(_) => self.start.scene = Some(value),
                None => return unknown("scene"),
            },
            "failure" => match bookmarks::find(&value) {
                Some(_) => {
                    self.start.scene = Some(value);
                    self.start.shows_failure = true;
                }
                None => return unknown("failure"),
            },
            "left" | "right" => match techniques::find(&value) {
                Some(_) => self.start.techniques[usize::from(key == "right")] = Some(value),
                None => return unknown("technique"),
            },
            "split" => {
                let sides = match (value.as_str(), value.parse::<f32>()) {
                    ("left", _) => (None, 0),
                    ("right", _) => (None, 1),
                    (_, Ok(at)) if (0.0..=1.0).contains(&at) => (Some(at), 0),
                    _ => return unknown("split"),
                };
                self.first_shown.sides = Some(sides);
            }
            "over" => {
                let known = Picture::ALL.iter().find(|(_, name)| *name == value);
                let Some((picture, _)) = known else {
                    return unknown("overlay");
                };
                self.first_shown.picture = Some(*picture);
            }
            _ => return Err(format!("unknown key `{key}`; the keys are {KEYS}")),
        }
        Ok(())
    }
}
