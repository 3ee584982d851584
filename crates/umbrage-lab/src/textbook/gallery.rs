//! Writes all effects into one self-contained page.

use super::{
    effect::{Effect, Preset},
    measure::{MeasuredEffect, Side},
};
use crate::output::html::{data_uri, document, escape};
use umbrage_core::ShadowTechnique as _;

const STYLE: &str = "\
body { font: 16px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 72rem; padding: 0 1rem; color: #1d2733; }
h1 { margin-bottom: 0; } h2 { margin: 3rem 0 .3rem; } p { max-width: 52rem; }
.pair { display: grid; grid-template-columns: 1fr 1fr; gap: 1.5rem; }
figure { margin: 0; } figcaption { margin: .3rem 0; }
.pictures { display: grid; grid-template-columns: 1fr 1fr; gap: 4px; }
img { width: 100%; border-radius: 4px; image-rendering: pixelated; display: block; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: 14px; }
td, th { padding: 0 1rem 0 0; text-align: left; font-weight: normal; } th { color: #5b6b7c; }
.better { color: #0a6b2d; } small { color: #5b6b7c; } .worse { border-left: 3px solid #d9a441; padding-left: .8rem; }
@media (max-width: 50rem) { .pair { grid-template-columns: 1fr; } }";

const TITLE: &str = "The textbooks' shadow effects";

/// Returns the page. `backends` holds the backends' full names.
pub fn html(rows: &[(&Effect, MeasuredEffect)], backends: &[String]) -> String {
    let mut body = format!(
        "<h1>{TITLE}</h1>\n\
         <p>Left: the artefact. Right: the fix. Next to each image is its error against ray-traced truth: blue is false shadow, \
         orange false light, grey faces away from the light. Rendered by {}.</p>\n",
        escape(&backends.join(" and "))
    );
    for (effect, rendered) in rows {
        body += &section(effect, rendered);
    }
    document(TITLE, STYLE, &body)
}

fn section(effect: &Effect, rendered: &MeasuredEffect) -> String {
    let head = format!(
        "<section id=\"{}\">\n<h2>{}</h2>\n<p>{}</p>\n",
        effect.name,
        escape(effect.title),
        escape(effect.text)
    );
    let left = figure(&effect.fault, &rendered.fault, None);
    let right = figure(&effect.cure, &rendered.cure, Some(&rendered.fault));
    let worse = effect.worse.map_or_else(String::new, |why| {
        format!("<p class=worse>{}</p>\n", escape(why))
    });
    format!("{head}<div class=pair>\n{left}{right}</div>\n{worse}</section>\n")
}

/// Returns one half of an effect. Mean errors below those of `than` are marked as better.
fn figure(preset: &Preset, side: &Side, than: Option<&Side>) -> String {
    let label = preset.label;
    let technique = (preset.technique)();
    let mut rows = String::new();
    for (i, (backend, errors)) in side.errors.iter().enumerate() {
        let other = than.and_then(|s| s.errors.get(i));
        let is_better = other.is_some_and(|(_, o)| errors.mean < o.mean);
        let class = if is_better { " class=better" } else { "" };
        let mean = 100.0 * errors.mean;
        let false_shadow = errors.false_shadow;
        let false_light = errors.false_light;
        rows += &format!(
            "<tr><td>{backend}<td{class}>{mean:.2} %<td>{false_shadow:.2} %<td>{false_light:.2} %</tr>\n"
        );
    }
    let differing = match (side.errors.len(), side.differing) {
        (0 | 1, _) => String::new(),
        (_, 0) => "<small>no pixel differs between the backends</small>".to_owned(),
        (_, n) => format!("<small>{n} pixels differ between the backends</small>"),
    };
    format!(
        "<figure><figcaption>{} <small>{}: {}</small></figcaption>\n<div class=pictures>{}{}</div>\n\
         <table><tr><th>backend<th>mean error<th>false shadow<th>false light</tr>\n{rows}</table>{differing}</figure>\n",
        escape(label),
        technique.name(),
        escape(&technique.settings()),
        picture(&side.picture, &format!("{label}: image")),
        picture(&side.error, &format!("{label}: error"))
    )
}

fn picture(png: &[u8], alt: &str) -> String {
    format!(
        "<img alt=\"{}\" src=\"{}\">",
        escape(alt),
        data_uri("image/png", png)
    )
}
