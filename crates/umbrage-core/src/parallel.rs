//! Parallel loops with the feature `parallel`; the same loops on one thread without it.
//!
//! With the feature this is [rayon](https://docs.rs/rayon). Without it, `prelude` has the rayon
//! methods that umbrage calls. Not part of the public API.

#[cfg(feature = "parallel")]
pub use rayon::{current_num_threads, prelude};

/// Returns the number of threads that loops run on.
#[cfg(not(feature = "parallel"))]
pub fn current_num_threads() -> usize {
    1
}

#[cfg(not(feature = "parallel"))]
pub use one_thread as prelude;

#[cfg(any(test, not(feature = "parallel")))]
pub mod one_thread {
    //! Rayon's traits, on one thread.

    use std::{
        cmp::Ordering,
        slice::{Chunks, ChunksExactMut, ChunksMut, Iter},
    };

    /// Values that can be iterated.
    pub trait IntoParallelIterator: IntoIterator + Sized {
        /// Returns the values in order.
        fn into_par_iter(self) -> OneThread<Self::IntoIter> {
            OneThread(self.into_iter())
        }
    }

    impl<I: IntoIterator> IntoParallelIterator for I {}

    /// Slices that can be iterated.
    pub trait ParallelSlice<T> {
        /// Returns the elements in order.
        fn par_iter(&self) -> OneThread<Iter<'_, T>>;
        /// Returns parts of `size` elements; the last one may have fewer.
        fn par_chunks(&self, size: usize) -> OneThread<Chunks<'_, T>>;
        /// Returns mutable parts of `size` elements; the last one may have fewer.
        fn par_chunks_mut(&mut self, size: usize) -> OneThread<ChunksMut<'_, T>>;
        /// Returns mutable parts of exactly `size` elements.
        fn par_chunks_exact_mut(&mut self, size: usize) -> OneThread<ChunksExactMut<'_, T>>;
        /// Sorts by `order`; equal elements may be reordered.
        fn par_sort_unstable_by(&mut self, order: impl FnMut(&T, &T) -> Ordering);
    }

    impl<T> ParallelSlice<T> for [T] {
        fn par_iter(&self) -> OneThread<Iter<'_, T>> {
            OneThread(self.iter())
        }

        fn par_chunks(&self, size: usize) -> OneThread<Chunks<'_, T>> {
            OneThread(self.chunks(size))
        }

        fn par_chunks_mut(&mut self, size: usize) -> OneThread<ChunksMut<'_, T>> {
            OneThread(self.chunks_mut(size))
        }

        fn par_chunks_exact_mut(&mut self, size: usize) -> OneThread<ChunksExactMut<'_, T>> {
            OneThread(self.chunks_exact_mut(size))
        }

        fn par_sort_unstable_by(&mut self, order: impl FnMut(&T, &T) -> Ordering) {
            self.sort_unstable_by(order);
        }
    }

    /// Iterator with rayon's methods. It overrides the methods of [`Iterator`] that rayon defines
    /// differently.
    #[derive(Clone, Debug)]
    pub struct OneThread<I>(I);

    impl<I: Iterator> Iterator for OneThread<I> {
        type Item = I::Item;

        fn next(&mut self) -> Option<I::Item> {
            self.0.next()
        }

        fn size_hint(&self) -> (usize, Option<usize>) {
            self.0.size_hint()
        }
    }

    impl<I: Iterator> OneThread<I> {
        /// Maps each value with `f`.
        pub fn map<T, F: FnMut(I::Item) -> T>(self, f: F) -> OneThread<std::iter::Map<I, F>> {
            OneThread(self.0.map(f))
        }

        /// Maps each value with `f`, which receives a state created by `init`.
        pub fn map_init<S, T>(
            self,
            init: impl FnOnce() -> S,
            mut f: impl FnMut(&mut S, I::Item) -> T,
        ) -> OneThread<impl Iterator<Item = T>> {
            let mut state = init();
            OneThread(self.0.map(move |value| f(&mut state, value)))
        }

        /// Returns the values for which `keep` is true.
        pub fn filter<F: FnMut(&I::Item) -> bool>(
            self,
            keep: F,
        ) -> OneThread<std::iter::Filter<I, F>> {
            OneThread(self.0.filter(keep))
        }

        /// Returns the values with their indices.
        pub fn enumerate(self) -> OneThread<std::iter::Enumerate<I>> {
            OneThread(self.0.enumerate())
        }

        /// Returns pairs of values, up to the length of the shorter iterator.
        pub fn zip<J: IntoIterator>(self, other: J) -> OneThread<std::iter::Zip<I, J::IntoIter>> {
            OneThread(self.0.zip(other))
        }

        /// Returns `self`: only a hint for threads.
        #[must_use]
        pub fn with_min_len(self, _: usize) -> Self {
            self
        }

        /// Combines all values, beginning with `identity`.
        pub fn reduce(
            self,
            identity: impl FnOnce() -> I::Item,
            f: impl FnMut(I::Item, I::Item) -> I::Item,
        ) -> I::Item {
            self.0.fold(identity(), f)
        }

        /// Returns the first value for which `f` returns `Some`.
        pub fn find_map_first<T>(mut self, f: impl FnMut(I::Item) -> Option<T>) -> Option<T> {
            self.0.find_map(f)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::one_thread::{IntoParallelIterator as _, ParallelSlice as _};
    use rayon::prelude as rayon;

    /// Each method has the same result on one thread as with rayon.
    #[test]
    fn one_thread_gives_what_many_give() {
        let numbers: Vec<i64> = (0..1000).map(|i| i * 7919 % 1009).collect();
        let other: Vec<i64> = numbers.iter().rev().copied().collect();

        let one: Vec<i64> = numbers.par_iter().map(|n| n * 3).collect();
        let many: Vec<i64> = rayon::ParallelIterator::collect(rayon::ParallelIterator::map(
            rayon::IntoParallelRefIterator::par_iter(&numbers),
            |n| n * 3,
        ));
        assert_eq!(one, many);

        // Sums of chunks, with a state that must not leak from one value to the next.
        let init = Vec::new;
        let sum = |state: &mut Vec<i64>, chunk: &[i64]| {
            state.clear();
            state.extend(chunk);
            state.iter().sum::<i64>()
        };
        let one: Vec<i64> = numbers.par_chunks(64).map_init(init, sum).collect();
        let many: Vec<i64> = rayon::ParallelIterator::collect(rayon::ParallelIterator::map_init(
            rayon::ParallelSlice::par_chunks(&numbers[..], 64),
            init,
            sum,
        ));
        assert_eq!(one, many);

        let pairs = numbers.par_iter().zip(&other).enumerate();
        let one = pairs
            .filter(|(i, _)| i % 3 == 0)
            .map(|(i, (a, b))| i as i64 + a - b)
            .with_min_len(8)
            .reduce(|| i64::MIN, i64::max);
        let expected = numbers.iter().zip(&other).enumerate().step_by(3);
        let expected = expected.map(|(i, (a, b))| i as i64 + a - b).max();
        assert_eq!(Some(one), expected);
        let nothing = Vec::<i64>::new().into_par_iter().reduce(|| 5, i64::max);
        assert_eq!(nothing, 5, "the identity");

        let first = (0..1000)
            .into_par_iter()
            .find_map_first(|i| (numbers[i] > 900).then_some(i));
        assert_eq!(first, numbers.iter().position(|&n| n > 900));

        let mut sorted = numbers.clone();
        sorted.par_sort_unstable_by(i64::cmp);
        assert!(sorted.is_sorted() && sorted.len() == numbers.len());

        let mut chunks = numbers.clone();
        chunks.par_chunks_mut(300).for_each(|chunk| chunk[0] = -1);
        let marked: Vec<usize> = (0..1000).filter(|&i| chunks[i] == -1).collect();
        assert_eq!(marked, [0, 300, 600, 900]);
        let mut exact = numbers.clone();
        let ids = (0..333).into_par_iter();
        exact
            .par_chunks_exact_mut(3)
            .zip(ids)
            .for_each(|(chunk, id)| chunk[2] = id);
        assert_eq!([exact[2], exact[998], exact[999]], [0, 332, numbers[999]]);
    }
}
