//! Twin functions: declared once, so that the lockstep tests can run both halves on the same inputs.

use crate::Module;
use glam::{IVec2, Mat4, UVec2, Vec2, Vec3, Vec4};

/// A function written in Rust and in WGSL under the same name.
#[derive(Clone, Copy, Debug)]
pub struct Twin {
    /// Its name in both languages.
    pub name: &'static str,
    /// The module that holds the WGSL half; `math` is always there too, other needs go to `needs`.
    pub module: Module,
    /// Modules that the WGSL half calls into.
    pub needs: &'static [Module],
    /// WGSL types of the parameters.
    pub parameters: &'static [&'static str],
    /// WGSL type of the result.
    pub result: &'static str,
    /// The Rust half over raw words: the parameters' components in order, 32 bits each.
    pub call: fn(&[u32]) -> Vec<u32>,
    /// Greatest difference allowed, in units in the last place; 0 means bit-equal.
    pub ulps: u32,
}

/// A type that both halves pass around, as 32-bit words.
pub trait Words: Sized {
    /// Its WGSL name.
    const WGSL: &'static str;
    /// How many words it takes.
    const COUNT: usize;
    /// Reads it from the front of `words`, which it shortens.
    fn take(words: &mut &[u32]) -> Self;
    /// Appends it.
    fn put(self, words: &mut Vec<u32>);
}

macro_rules! words {
    ($($t:ty, $wgsl:literal, $count:literal, $from:expr, $to:expr;)*) => {$(
        impl Words for $t {
            const WGSL: &'static str = $wgsl;
            const COUNT: usize = $count;
            fn take(words: &mut &[u32]) -> Self {
                let (head, tail) = words.split_at($count);
                *words = tail;
                let from: fn(&[u32]) -> Self = $from;
                from(head)
            }
            fn put(self, words: &mut Vec<u32>) {
                let to: fn(Self) -> Vec<u32> = $to;
                words.extend(to(self));
            }
        }
    )*};
}

fn floats<const N: usize>(words: &[u32]) -> [f32; N] {
    std::array::from_fn(|i| f32::from_bits(words[i]))
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|v| v.to_bits()).collect()
}

words! {
    f32, "f32", 1, |w| f32::from_bits(w[0]), |v| vec![v.to_bits()];
    u32, "u32", 1, |w| w[0], |v| vec![v];
    i32, "i32", 1, |w| w[0] as i32, |v| vec![v as u32];
    Vec2, "vec2f", 2, |w| Vec2::from_array(floats(w)), |v| bits(&v.to_array());
    Vec3, "vec3f", 3, |w| Vec3::from_array(floats(w)), |v| bits(&v.to_array());
    Vec4, "vec4f", 4, |w| Vec4::from_array(floats(w)), |v| bits(&v.to_array());
    Mat4, "mat4x4f", 16, |w| Mat4::from_cols_array(&floats(w)), |v| bits(&v.to_cols_array());
    UVec2, "vec2u", 2, |w| UVec2::new(w[0], w[1]), |v| v.to_array().to_vec();
    IVec2, "vec2i", 2, |w| IVec2::new(w[0] as i32, w[1] as i32), |v| v.to_array().map(|x| x as u32).to_vec();
}

/// Declares a twin: `twin!(MODULE, name(a: Vec3, b: f32) -> f32)`, bit-equal; `twin!(.., ulps 2)` allows a difference;
/// `twin!(.., needs [OTHER])` names modules that the WGSL half calls into.
#[macro_export]
macro_rules! twin {
    ($module:expr, $name:ident($($p:ident: $t:ty),*) -> $r:ty $(, needs [$($need:expr),*])? $(, ulps $ulps:expr)?) => {
        $crate::Twin {
            name: stringify!($name),
            module: $module,
            needs: &[$($($need),*)?],
            parameters: &[$(<$t as $crate::Words>::WGSL),*],
            result: <$r as $crate::Words>::WGSL,
            call: |mut words| {
                let words = &mut words;
                $(let $p = <$t as $crate::Words>::take(words);)*
                let result: $r = $name($($p),*);
                let mut out = Vec::new();
                $crate::Words::put(result, &mut out);
                out
            },
            ulps: 0 $(+ $ulps)?,
        }
    };
}
