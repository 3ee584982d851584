//! Text of the page.

use super::{
    HEADLINE,
    cells::{budget_words, cell, cell_below, error_words, frame_words, hard_words, words_of},
    document::{Block, Document, Inline, anchor, text},
    environment,
    groups::{Answer, BUDGETS, LIGHTS, OfBackend, POOR, SIZES, WhichGroup, heading},
    is_software,
    pictures::Shown,
};
use crate::{
    card::Card,
    compare::{percent, thousands},
    report::{MeasuredScene, StabilitySource},
};

/// Inputs of the page.
pub(super) struct AnswerWords<'a> {
    pub(super) scenes: &'a [MeasuredScene],
    /// Groups; at least one.
    pub(super) groups: &'a [WhichGroup],
    pub(super) stability: &'a StabilitySource,
    pub(super) pictures: &'a Shown,
    /// Card whose times the page shows.
    pub(super) card: Option<&'a Card>,
    /// Whether there is a chart.
    pub(super) has_chart: bool,
    /// Command that regenerates the page.
    pub(super) command: &'a str,
}

/// Budgets of the short table, as indices in [`BUDGETS`]: the smallest, a middle one, unlimited.
const SHORT: [usize; 3] = [0, 2, BUDGETS.len() - 1];
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
        let adapter = match (&e.adapter, self.card) {
            (_, Some(card)) => format!(
                "times of {} from {}{}",
                card.adapter,
                card.date.as_deref().unwrap_or("an unknown date"),
                card.commit
                    .as_ref()
                    .map_or_else(String::new, |c| format!(" at commit {c}"))
            ),
            (Some(adapter), _) if is_software(adapter) => format!(
                "times of wgpu are omitted, as {adapter} is a software driver: not yet measured on hardware"
            ),
            (Some(adapter), _) => format!("wgpu on {adapter}"),
            (None, _) => "not yet measured on a graphics card".to_owned(),
        };
        let measured = format!(
            "Measured by umbrage {}{}{} on {}, {} threads; {adapter}. Other settings may win on other machines: run it on yours.",
            e.version,
            commit.unwrap_or_default(),
            date.unwrap_or_default(),
            e.cpu,
            e.threads
        );
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
                    Inline::Bold("None is good".to_owned()),
                    text(format!(
                        " means that every setting within the budget is more than {} as wrong as no shadow. The cell then also names the fastest setting below that error.",
                        percent(POOR)
                    )),
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

    /// Returns the answers of each group's first backend while the camera moves, a line per group.
    fn short(&self) -> Vec<Block> {
        let mut rows = Vec::new();
        for group in self.groups {
            let title = group.heading();
            let link = format!("#{}", anchor(&title));
            let first = &group.backends[0];
            let mut row = vec![
                vec![Inline::Link(title, link)],
                vec![text(first.backend.clone())],
            ];
            for budget in SHORT {
                row.push(cell(group, first, budget, first.usual_motion()));
            }
            rows.push(row);
        }
        let mut head = vec!["light, size".to_owned(), "measured on".to_owned()];
        head.extend(SHORT.map(budget_words));
        let mut out = vec![
            Block::Heading(2, "In short".to_owned()),
            Block::Paragraph(vec![text("While the camera moves, by frame budget:")]),
            Block::Table { head, rows },
        ];
        if self.has_chart {
            let what = "error against time of ten settings under a sun without extent";
            let chart = Inline::Image(what.to_owned(), HEADLINE.to_owned());
            out.push(Block::Paragraph(vec![chart]));
        }
        out
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
            out.push(Block::Paragraph(hard_words(of_backend)));
            let mut head = vec!["frame budget".to_owned()];
            head.extend(
                of_backend
                    .motions
                    .iter()
                    .map(|(_, words)| (*words).to_owned()),
            );
            let mut rows = Vec::new();
            for budget in 0..BUDGETS.len() {
                // Omit a budget that changes nothing under any motion.
                if budget > 0 && of_backend.table[budget] == of_backend.table[budget - 1] {
                    continue;
                }
                let mut row = vec![vec![text(budget_words(budget))]];
                for motion in 0..of_backend.motions.len() {
                    row.push(cell_below(group, of_backend, budget, motion));
                }
                rows.push(row);
            }
            out.push(Block::Table { head, rows });
        }
        out.push(Block::Table {
            head: [
                "answer, with truth, mask and error",
                "error",
                "frame time",
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
        // A card may have timed only some of the scenes.
        let scenes = group.scenes.len();
        let has_all = |of: &OfBackend| of.scenes.len() == scenes;
        for of in &group.backends {
            let error = of.setting(answer, of.usual_motion()).map(error_words);
            // Most answers have the same error on all backends; list it once.
            let is_new = |error: &String| has_all(of) && !errors.contains(error);
            errors.extend(error.filter(is_new));
            if let Some(line) = frame_words(of, answer) {
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
}
