//! How the page's address says what is shown first: `?scene=cubes&left=hard&right=exact&split=0.5&over=error`.

use crate::{
    bookmarks,
    measure::figures::Picture,
    state::{Settings, Start},
};
use umbrage::{scenes, techniques};
use web_sys::UrlSearchParams;

/// The keys, for messages.
const KEYS: &str = "scene, failure, left, right, split (0 to 1, or `left` or `right`) and over (nothing, error, truth or mask)";

/// What the address asks for.
#[derive(Default)]
pub(super) struct Query {
    pub start: Start,
    split: Option<Split>,
    picture: Option<Picture>,
}

enum Split {
    At(f32),
    Only(usize),
}

impl Query {
    /// Reads the page's address. What can't be understood is left aside, and a message names it.
    pub(super) fn of_page() -> Self {
        let address = web_sys::window().and_then(|window| window.location().search().ok());
        let mut out = Self::default();
        let Some(parameters) = address
            .filter(|text| !text.is_empty())
            .and_then(|text| UrlSearchParams::new_with_str(&text).ok())
        else {
            return out;
        };
        // A link shows everybody the same.
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
                None => return unknown("place of failure"),
            },
            "left" | "right" => match techniques::find(&value) {
                Some(_) => self.start.techniques[usize::from(key == "right")] = Some(value),
                None => return unknown("technique"),
            },
            "split" => match (value.as_str(), value.parse::<f32>()) {
                ("left", _) => self.split = Some(Split::Only(0)),
                ("right", _) => self.split = Some(Split::Only(1)),
                (_, Ok(at)) if (0.0..=1.0).contains(&at) => self.split = Some(Split::At(at)),
                _ => return unknown("split"),
            },
            "over" => match value.as_str() {
                "nothing" => self.picture = Some(Picture::Nothing),
                "error" => self.picture = Some(Picture::Error),
                "truth" => self.picture = Some(Picture::Truth),
                "mask" => self.picture = Some(Picture::Mask),
                _ => return unknown("picture to lay over"),
            },
            _ => return Err(format!("`{key}` means nothing; the keys are {KEYS}")),
        }
        Ok(())
    }

    /// Brings settings to what was asked for beyond the start.
    pub(super) fn apply(&self, settings: &mut Settings) {
        match self.split {
            Some(Split::At(at)) => settings.split = Some(at),
            Some(Split::Only(side)) => {
                settings.split = None;
                settings.shown_side = side;
            }
            None => {}
        }
        if let Some(picture) = self.picture {
            settings.picture = picture;
        }
    }
}
