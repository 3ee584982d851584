//! Textbook effects as presets: settings that show an artefact, and settings that fix it, with the
//! textbooks' numbers. [`measure()`] measures and renders both; [`html`] writes one page of all
//! effects.

mod effect;
mod effects;
mod gallery;
mod measure;

pub use effect::{Effect, Preset};
pub use effects::all;
pub use gallery::html;
pub use measure::{MeasuredEffect, Side, measure};

/// Returns the effect of this name.
pub fn find(name: &str) -> Option<&'static Effect> {
    all().iter().find(|e| e.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_core::Backend;
    use umbrage_cpu::Cpu;

    #[test]
    fn no_cure_is_worse_than_its_fault_unless_the_page_says_why() {
        let mut backends: Vec<Box<dyn Backend + Send>> = vec![Box::new(Cpu::new())];
        for effect in all() {
            let rendered =
                measure(effect, &mut backends).unwrap_or_else(|e| panic!("{}: {e}", effect.name));
            let [before, after] =
                [&rendered.fault, &rendered.cure].map(|side| side.errors[0].1.mean);
            assert_eq!(
                after > before,
                effect.worse.is_some(),
                "{}: {before} to {after}",
                effect.name
            );
            assert_ne!(
                rendered.fault.picture, rendered.cure.picture,
                "{}",
                effect.name
            );
            let page = html(&[(effect, rendered)], &[]);
            assert_eq!(
                page.contains("<p class=worse>"),
                effect.worse.is_some(),
                "{}",
                effect.name
            );
            assert!(
                effect.worse.is_none_or(|why| page.contains(why)),
                "{}",
                effect.name
            );
        }
    }

    #[test]
    fn names_are_file_names_and_differ() {
        let names: std::collections::HashSet<_> = all().iter().map(|e| e.name).collect();
        assert_eq!(names.len(), all().len());
        assert!(
            names
                .iter()
                .all(|n| n.chars().all(|c| c.is_ascii_lowercase() || c == '-'))
        );
        assert!(find("acne").is_some() && find("beauty").is_none());
    }
}
