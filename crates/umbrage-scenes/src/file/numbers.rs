//! Numbers of a scene file.

use super::table::{Item, Table};
use crate::SceneError;
use std::{ops::RangeInclusive, str::FromStr};
use toml::de::DeValue;
use umbrage_core::glam::{DVec3, Vec3};
use umbrage_core::{Anchor, Invalid, invalid};

const TRIPLE: &str = "[x, y, z]";

impl Item<'_> {
    /// Reads a finite number, integer or not.
    pub(super) fn number(&self) -> Result<f32, SceneError> {
        let number = self.parse_number(|i| i as f32)?;
        self.check(invalid::finite("", &[number]))?;
        Ok(number)
    }

    /// Reads a number as 64 bits, integer or not.
    pub(super) fn wide_number(&self) -> Result<f64, SceneError> {
        self.parse_number(|i| i as f64)
    }

    fn parse_number<T: FromStr>(&self, from_whole: fn(i64) -> T) -> Result<T, SceneError> {
        let parsed = match self.value {
            DeValue::Integer(i) => i64::from_str_radix(i.as_str(), i.radix())
                .ok()
                .map(from_whole),
            DeValue::Float(f) => f.as_str().parse().ok(),
            _ => return Err(self.wrong_type("a number", "write it as 2 or 1.5, without quotes")),
        };
        parsed.ok_or_else(|| self.fault("is out of range", "use a smaller number"))
    }

    /// Reads a finite number that passes a check of core's.
    pub(super) fn read_checked_number(
        &self,
        check: fn(&str, f32) -> Result<(), Invalid>,
    ) -> Result<f32, SceneError> {
        let number = self.number()?;
        self.check(check("", number))?;
        Ok(number)
    }

    /// Reads an integer in a range.
    pub(super) fn whole(&self, range: RangeInclusive<u32>) -> Result<u32, SceneError> {
        let help = format!(
            "use a whole number from {} to {}",
            range.start(),
            range.end()
        );
        let DeValue::Integer(i) = self.value else {
            return Err(self.wrong_type("a whole number", &help));
        };
        let number = u32::from_str_radix(i.as_str(), i.radix());
        let number = number.ok().filter(|n| range.contains(n));
        number.ok_or_else(|| self.fault(&format!("holds {i}"), &help))
    }

    pub(super) fn vec3(&self) -> Result<Vec3, SceneError> {
        self.triple(Item::number).map(Vec3::from_array)
    }

    pub(super) fn wide_vec3(&self) -> Result<DVec3, SceneError> {
        self.triple(Item::wide_number).map(DVec3::from_array)
    }

    fn triple<T>(
        &self,
        number: impl Fn(&Self) -> Result<T, SceneError>,
    ) -> Result<[T; 3], SceneError> {
        let items = self.list(3, TRIPLE)?;
        Ok([number(&items[0])?, number(&items[1])?, number(&items[2])?])
    }

    /// Reads a position in world space, relative to an anchor.
    pub(super) fn position(&self, anchor: Anchor) -> Result<Vec3, SceneError> {
        let relative = anchor.position(self.wide_vec3()?);
        self.check(invalid::finite("", &relative.to_array()))?;
        Ok(relative)
    }

    /// Reads a vector of non-zero length.
    pub(super) fn direction(&self) -> Result<Vec3, SceneError> {
        let v = self.vec3()?;
        self.check(invalid::direction("", v))?;
        Ok(v)
    }
}

impl Table<'_> {
    /// Reads a position in world space, relative to an anchor.
    pub(super) fn position(&self, key: &str, anchor: Anchor) -> Result<Vec3, SceneError> {
        self.need(key, TRIPLE)?.position(anchor)
    }

    /// Returns the origin of the file's positions: the anchor nearest to the point `anchor`. `None`
    /// without one.
    pub(super) fn anchor(&self) -> Result<Option<Anchor>, SceneError> {
        self.get("anchor")
            .map(|item| item.check(Anchor::nearest_to(item.wide_vec3()?)))
            .transpose()
    }

    pub(super) fn direction(&self, key: &str) -> Result<Vec3, SceneError> {
        self.need(key, TRIPLE)?.direction()
    }

    /// Reads metres or degrees, not negative; 0 if absent.
    pub(super) fn size_or_zero(&self, key: &str) -> Result<f32, SceneError> {
        self.get(key).map_or(Ok(0.0), |item| {
            item.read_checked_number(invalid::not_negative)
        })
    }

    pub(super) fn flag_or_true(&self, key: &str) -> Result<bool, SceneError> {
        self.get(key).map_or(Ok(true), |item| item.flag())
    }
}
