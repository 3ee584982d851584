//! Text of the page.

use super::{
    document::{Block, Document, Inline, anchor, text},
    environment,
    groups::{Answer, BUDGETS, LIGHTS, MOTIONS, OfBackend, SIZES, WhichGroup, heading},
    pictures::Shown,
};
use crate::{
    compare::{CostBasis, FrameMotion, Measured, Relative, percent, thousands, times},
    report::{MeasuredScene, StabilitySource},
};
use umbrage_techniques::ShadowMap;

/// Inputs of the page.
pub(super) struct AnswerWords<'a> {
    pub(super) scenes: &'a [MeasuredScene],
    /// Groups; at least one.
    pub(super) groups: &'a [WhichGroup],
    pub(super) stability: &'a StabilitySource,
    pub(super) pictures: &'a Shown,
    /// Command that regenerates the page.
    pub(super) command: &'a str,
}

/// Budgets of the short table, as indices in [`BUDGETS`]: the smallest, a middle one, unlimited.
const SHORT: [usize; 3] = [0, 2, BUDGETS.len() - 1];
/// Motion of the short table, as an index in [`MOTIONS`]: the camera moves.
const USUAL: usize = 1;
/// Parts of the names of adapters that run on the CPU.
const SOFTWARE: [&str; 2] = ["llvmpipe", "SwiftShader"];
/// Greatest number of `stability` rows that an answer lists.
const NAMED_ROWS: usize = 40;

impl AnswerWords<'_> {
    pub(super) fn document(&self) -> Document {
        let mut blocks = self.beginning();
        blocks.extend(self.short());
        blocks.extend(self.not_measured());
        for (place, group) in self.groups.iter().enumerate() {
            blocks.extend(self.group(group, &self.pictures[place]));
        }
        Document { blocks }
    }

    fn beginning(&self) -> Vec<Block> {
        let e = environment(self.scenes);
        let commit = e.commit.as_ref().map(|c| format!(" at commit {c}"));
        let date = e.date.as_ref().map(|d| format!(", {d} UTC"));
        let adapter = match &e.adapter {
            Some(adapter) => format!("wgpu on {adapter}"),
            None => "without a graphics adapter".to_owned(),
        };
        let measured = format!(
            "Measured by umbrage {}{}{} on {}, {} threads; {adapter}. Other settings may win on other machines: run it on yours.",
            e.version,
            commit.unwrap_or_default(),
            date.unwrap_or_default(),
            e.cpu,
            e.threads
        );
        let is_software = |adapter: &String| SOFTWARE.iter().any(|name| adapter.contains(name));
        let measured = if e.adapter.as_ref().is_some_and(is_software) {
            measured
                + " (That adapter is a software driver: its times do not represent a graphics card.)"
        } else {
            measured
        };
        let first = &self.scenes[0];
        let stale = self
            .stability
            .stale_against(&first.program, &first.environment);
        let mut out = vec![
            Block::Heading(1, "Which technique should I use?".to_owned()),
            Block::Paragraph(vec![
                text("Every answer here is computed from measurements, by "),
                Inline::Code(self.command.to_owned()),
                text("; none is chosen by hand. "),
                text(measured),
            ]),
            Block::List(vec![
                vec![
                    Inline::Bold("An answer".to_owned()),
                    text(
                        " is the fastest setting within the budget whose error is at most a tenth above the least one. Budgets that change nothing are omitted.",
                    ),
                ],
                vec![
                    Inline::Bold("Error".to_owned()),
                    text(
                        " is the mask's error against ray-traced truth, relative to drawing no shadow: 0 % is exact, 100 % is as wrong as no shadow.",
                    ),
                ],
                vec![
                    Inline::Bold("Time".to_owned()),
                    text(" is a frame's time, as a multiple of that of a "),
                    Inline::Code("hard".to_owned()),
                    text(
                        " map of middle size in the same scene. It counts the lookup while nothing moves; also the work that follows the camera while the camera moves; and all work, including hierarchies over the triangles, while all moves.",
                    ),
                ],
                vec![
                    Inline::Bold("Settings".to_owned()),
                    text(
                        " are the kernel and the map's side in texels; maps have the default bias unless another is named.",
                    ),
                ],
                vec![
                    Inline::Bold("Fails".to_owned()),
                    text(format!(
                        " counts failed rows of the failure catalogue, from stability: {}.",
                        self.stability.description()
                    )),
                ],
            ]),
        ];
        if let Some(why) = stale {
            out.push(Block::Paragraph(vec![
                Inline::Bold("Note:".to_owned()),
                text(format!(" failed rows were {why}.")),
            ]));
        }
        out
    }

    /// Returns the answers of the first backend while the camera moves, one line per group.
    fn short(&self) -> Vec<Block> {
        let mut rows = Vec::new();
        for group in self.groups {
            let title = group.heading();
            let link = format!("#{}", anchor(&title));
            let mut row = vec![vec![Inline::Link(title, link)]];
            for budget in SHORT {
                row.push(self.cell(group, &group.backends[0], budget, USUAL));
            }
            rows.push(row);
        }
        let mut head = vec!["light, size".to_owned()];
        head.extend(SHORT.map(budget_words));
        let backend = &self.groups[0].backends[0].backend;
        vec![
            Block::Heading(2, "In short".to_owned()),
            Block::Paragraph(vec![text(format!(
                "While the camera moves, on {backend}, by frame budget:"
            ))]),
            Block::Table { head, rows },
        ]
    }

    /// Lists the kinds of light and sizes without a scene; `None` if there are none.
    fn not_measured(&self) -> Option<Block> {
        let mut missing: Vec<String> = Vec::new();
        for light in 0..LIGHTS.len() {
            for is_ideal in [true, false] {
                for size in 0..SIZES.len() {
                    let is_it = |g: &WhichGroup| {
                        g.light == light && g.is_ideal == is_ideal && g.size == size
                    };
                    if !self.groups.iter().any(is_it) {
                        missing.push(heading(light, is_ideal, size));
                    }
                }
            }
        }
        (!missing.is_empty()).then(|| {
            Block::Paragraph(vec![
                Inline::Bold("Not measured".to_owned()),
                text(format!(" (no scene of this kind): {}.", missing.join("; "))),
            ])
        })
    }

    fn group(&self, group: &WhichGroup, pictures: &[Option<String>]) -> Vec<Block> {
        let mut names = Vec::new();
        for &place in &group.scenes {
            let scene = &self.scenes[place].result;
            let [w, h] = scene.size;
            names.push(format!(
                "{} ({} triangles, {w}x{h})",
                scene.name,
                thousands(scene.triangles)
            ));
        }
        let noun = if names.len() == 1 {
            "one scene"
        } else {
            "scenes"
        };
        let mut out = vec![
            Block::Heading(2, group.heading()),
            Block::Paragraph(vec![text(format!("From {noun}: {}.", names.join(", ")))]),
        ];
        for of_backend in &group.backends {
            out.push(Block::Paragraph(self.hard_words(group, of_backend)));
            let mut head = vec!["frame budget".to_owned()];
            head.extend(MOTIONS.map(|(_, words)| words.to_owned()));
            let mut rows = Vec::new();
            for budget in 0..BUDGETS.len() {
                // Omit a budget that changes nothing under any motion.
                if budget > 0 && of_backend.table[budget] == of_backend.table[budget - 1] {
                    continue;
                }
                let mut row = vec![vec![text(budget_words(budget))]];
                for motion in 0..MOTIONS.len() {
                    row.push(self.cell_below(group, of_backend, budget, motion));
                }
                rows.push(row);
            }
            out.push(Block::Table { head, rows });
        }
        out.push(Block::Table {
            head: [
                "answer, with truth, mask and error",
                "error",
                "frame time: still, camera moves, all moves",
                "fails",
            ]
            .map(str::to_owned)
            .to_vec(),
            rows: (0..group.answers.len())
                .map(|answer| self.answer(group, &group.answers[answer], pictures.get(answer)))
                .collect(),
        });
        out
    }

    /// Returns a cell of a table of all budgets: `as above` if the larger budget changes nothing.
    fn cell_below(
        &self,
        group: &WhichGroup,
        of: &OfBackend,
        budget: usize,
        motion: usize,
    ) -> Vec<Inline> {
        let is_as_above = budget > 0 && of.table[budget][motion] == of.table[budget - 1][motion];
        if is_as_above {
            vec![text("as above")]
        } else {
            self.cell(group, of, budget, motion)
        }
    }

    /// Returns a cell of a table of budgets: the answer, its error and its time.
    fn cell(
        &self,
        group: &WhichGroup,
        of: &OfBackend,
        budget: usize,
        motion: usize,
    ) -> Vec<Inline> {
        let Some(place) = of.table[budget][motion] else {
            return vec![text("no setting is better than no shadow")];
        };
        let answer = &group.answers[place];
        let Some(setting) = of.setting(answer, motion) else {
            return Vec::new();
        };
        let time = setting.take(of.clock).map_or_else(String::new, times);
        vec![
            Inline::Bold(answer.technique.clone()),
            text(format!(
                " {}: {}, {time}",
                words_of(answer),
                error_words(setting)
            )),
        ]
    }

    /// Returns a line with the backend and the time of `hard` on it.
    fn hard_words(&self, group: &WhichGroup, of: &OfBackend) -> Vec<Inline> {
        let mut parts = Vec::new();
        for (motion, (kind, words)) in MOTIONS.iter().enumerate() {
            let near_one = |s: &&Relative| {
                let time = s.take(of.clock).unwrap_or(f64::NAN);
                s.technique == "hard" && (time - 1.0).abs() < 1e-6
            };
            let Some(hard) = of.settings[motion].iter().find(near_one) else {
                continue;
            };
            let answer = Answer {
                technique: hard.technique.clone(),
                settings: hard.settings.clone(),
            };
            if let Some(ms) = self.milliseconds(group, of, &answer, *kind) {
                parts.push(format!("{} ms while {words}", short(ms)));
            }
        }
        let clock = match of.clock {
            CostBasis::Wall => "takes",
            CostBasis::Cost => "(by counted cost, not timed) takes",
        };
        vec![
            text("On "),
            Inline::Bold(of.backend.clone()),
            text(", "),
            Inline::Code("hard".to_owned()),
            text(format!(" {clock} {}:", parts.join(", "))),
        ]
    }

    /// Returns the geometric mean of a setting's frame times over the group's scenes, milliseconds;
    /// `None` if any scene lacks one.
    fn milliseconds(
        &self,
        group: &WhichGroup,
        of: &OfBackend,
        answer: &Answer,
        motion: FrameMotion,
    ) -> Option<f64> {
        let mut logarithms = 0.0;
        for &place in &group.scenes {
            let measured = self.measured_figures(place, &of.backend, answer)?;
            logarithms += measured.milliseconds(of.clock, motion)?.ln();
        }
        Some((logarithms / group.scenes.len() as f64).exp())
    }

    /// Returns the measurement of a setting on a scene and backend.
    fn measured_figures(&self, scene: usize, backend: &str, answer: &Answer) -> Option<&Measured> {
        let mut rows = self.scenes[scene].result.rows.iter();
        let row = rows.find(|row| {
            row.backend == backend
                && row.technique == answer.technique
                && row.settings == answer.settings
        })?;
        row.measured_figures()
    }

    /// Returns an answer's table row: its image, its errors, its times on all backends, and the
    /// `stability` rows that it fails.
    fn answer(
        &self,
        group: &WhichGroup,
        answer: &Answer,
        picture: Option<&Option<String>>,
    ) -> Vec<Vec<Inline>> {
        let name = format!("{} ({})", answer.technique, answer.settings);
        let mut shown = vec![
            Inline::Bold(answer.technique.clone()),
            text(format!(" {}", words_of(answer))),
            Inline::Break,
        ];
        shown.push(match picture {
            Some(Some(file)) => {
                Inline::Image(format!("truth, mask and error of {name}"), file.clone())
            }
            _ => text("no image was kept"),
        });
        let mut errors = Vec::new();
        let mut frames = Vec::new();
        for of in &group.backends {
            let error = of.setting(answer, USUAL).map(error_words);
            // Most answers have the same error on all backends; list it once.
            errors.extend(error.filter(|error| !errors.contains(error)));
            if let Some(line) = self.frame_words(group, of, answer) {
                if !frames.is_empty() {
                    frames.push(Inline::Break);
                }
                frames.push(text(line));
            }
        }
        let verdicts = self
            .stability
            .verdicts_of(&answer.technique, &answer.settings);
        let fails = match verdicts {
            Some(verdicts) if verdicts.is_of(&answer.technique, &answer.settings) => {
                verdicts.words(NAMED_ROWS)
            }
            Some(verdicts) => {
                format!(
                    "{} (tested as {})",
                    verdicts.words(NAMED_ROWS),
                    verdicts.settings
                )
            }
            None => "not measured".to_owned(),
        };
        vec![
            shown,
            vec![text(errors.join("; "))],
            frames,
            vec![text(fails)],
        ]
    }

    /// Returns a setting's frame times on a backend: milliseconds, and multiples of `hard`.
    fn frame_words(&self, group: &WhichGroup, of: &OfBackend, answer: &Answer) -> Option<String> {
        let mut ms = Vec::new();
        let mut ratios = Vec::new();
        for (motion, (kind, _)) in MOTIONS.iter().enumerate() {
            ms.push(short(self.milliseconds(group, of, answer, *kind)?));
            ratios.push(digits(of.setting(answer, motion)?.take(of.clock)?));
        }
        let backend = &of.backend;
        Some(format!(
            "{backend}: {} ms ({} times hard)",
            ms.join(", "),
            ratios.join(", ")
        ))
    }
}

/// Returns an answer's settings without the default bias, which the page states once.
fn words_of(answer: &Answer) -> String {
    let default = ShadowMap::default().bias.label();
    let words = answer.settings.split(", ").filter(|word| *word != default);
    words.collect::<Vec<_>>().join(", ")
}

fn error_words(setting: &Relative) -> String {
    if setting.is_exact() {
        "exact".to_owned()
    } else {
        percent(setting.error)
    }
}

/// Returns a budget's label, by its index in [`BUDGETS`].
fn budget_words(budget: usize) -> String {
    let times = BUDGETS[budget];
    if times.is_infinite() {
        "unlimited".to_owned()
    } else {
        format!("{times} times hard")
    }
}

/// Formats milliseconds with three digits.
fn short(ms: f64) -> String {
    match ms {
        _ if ms >= 100.0 => format!("{ms:.0}"),
        _ if ms >= 10.0 => format!("{ms:.1}"),
        _ => format!("{ms:.2}"),
    }
}

/// Formats a ratio with two digits.
fn digits(ratio: f64) -> String {
    if ratio < 10.0 {
        format!("{ratio:.1}")
    } else {
        format!("{ratio:.0}")
    }
}
