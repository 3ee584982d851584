//! Twin functions, written in Rust and in WGSL. Each pair is declared once, and tests run both on
//! the same inputs.

use crate::recipe::shader::Module;
use glam::{IVec2, Mat4, UVec2, Vec2, Vec3, Vec4};

/// A function written in Rust and in WGSL under the same name.
#[derive(Clone, Copy, Debug)]
pub struct Twin {
    /// Name in both languages.
    pub name: &'static str,
    /// Module of the WGSL half.
    pub module: Module,
    /// Modules that the WGSL half calls, other than `math`, which is always included.
    pub needs: &'static [Module],
    /// WGSL types of the parameters.
    pub parameters: &'static [&'static str],
    /// WGSL type of the result.
    pub result: &'static str,
    /// The Rust half on raw words: the parameters' components in order, 32 bits each.
    pub call: fn(&[u32]) -> Vec<u32>,
    /// Greatest allowed difference, in units in the last place; 0 means bit-equal.
    pub ulps: u32,
}

/// A parameter or result type of twins, as a sequence of 32-bit words.
pub trait Words: Sized {
    /// WGSL name of the type.
    const WGSL: &'static str;
    /// Number of words.
    const COUNT: usize;
    /// Reads a value from the front of `words`, and advances `words`.
    fn take(words: &mut &[u32]) -> Self;
    /// Appends the value to `words`.
    fn put(self, words: &mut Vec<u32>);
}

impl Words for u32 {
    const WGSL: &'static str = "u32";
    const COUNT: usize = 1;

    fn take(words: &mut &[u32]) -> Self {
        let value = words[0];
        *words = &words[1..];
        value
    }

    fn put(self, words: &mut Vec<u32>) {
        words.push(self);
    }
}

impl Words for i32 {
    const WGSL: &'static str = "i32";
    const COUNT: usize = 1;

    fn take(words: &mut &[u32]) -> Self {
        u32::take(words).cast_signed()
    }

    fn put(self, words: &mut Vec<u32>) {
        words.push(self.cast_unsigned());
    }
}

impl Words for f32 {
    const WGSL: &'static str = "f32";
    const COUNT: usize = 1;

    fn take(words: &mut &[u32]) -> Self {
        f32::from_bits(u32::take(words))
    }

    fn put(self, words: &mut Vec<u32>) {
        words.push(self.to_bits());
    }
}

/// Implements [`Words`] for a type of `glam` that consists of `$count` components of type
/// `$component`.
macro_rules! impl_words {
    ($t:ty, $wgsl:literal, [$component:ty; $count:literal], $from_array:expr, $to_array:expr) => {
        impl Words for $t {
            const WGSL: &'static str = $wgsl;
            const COUNT: usize = $count;

            fn take(words: &mut &[u32]) -> Self {
                let components: [$component; $count] =
                    std::array::from_fn(|_| <$component>::take(words));
                $from_array(components)
            }

            fn put(self, words: &mut Vec<u32>) {
                let components: [$component; $count] = $to_array(&self);
                for component in components {
                    component.put(words);
                }
            }
        }
    };
}

impl_words!(Vec2, "vec2f", [f32; 2], Vec2::from_array, Vec2::to_array);
impl_words!(Vec3, "vec3f", [f32; 3], Vec3::from_array, Vec3::to_array);
impl_words!(Vec4, "vec4f", [f32; 4], Vec4::from_array, Vec4::to_array);
impl_words!(UVec2, "vec2u", [u32; 2], UVec2::from_array, UVec2::to_array);
impl_words!(IVec2, "vec2i", [i32; 2], IVec2::from_array, IVec2::to_array);
impl_words!(
    Mat4,
    "mat4x4f",
    [f32; 16],
    matrix_from_columns,
    Mat4::to_cols_array
);

fn matrix_from_columns(components: [f32; 16]) -> Mat4 {
    Mat4::from_cols_array(&components)
}

/// Declares a twin. `twin!(MODULE, name(a: Vec3, b: f32) -> f32)` is bit-equal; `twin!(.., ulps 2)`
/// allows a difference; `twin!(.., needs [OTHER])` lists modules that the WGSL half calls.
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
