//! Loops over several threads, with the feature `parallel`; without it the same loops over one.
//!
//! With the feature this is [rayon](https://docs.rs/rayon). Without it, `prelude` has the methods
//! of rayon's that umbrage calls, as methods of the standard library's iterators and slices.

#[cfg(feature = "parallel")]
pub use rayon::{current_num_threads, prelude};

/// Returns the number of threads that loops run on.
#[cfg(not(feature = "parallel"))]
pub fn current_num_threads() -> usize {
    1
}

#[cfg(not(feature = "parallel"))]
pub mod prelude {
    //! Rayon's traits, on one thread.

    use std::{
        cmp::Ordering,
        slice::{Chunks, ChunksExactMut, ChunksMut, Iter},
    };

    /// Values that can be gone through.
    pub trait IntoParallelIterator: IntoIterator + Sized {
        /// Returns the values in order.
        fn into_par_iter(self) -> OneThread<Self::IntoIter> {
            OneThread(self.into_iter())
        }
    }

    impl<I: IntoIterator> IntoParallelIterator for I {}

    /// Slices that can be gone through.
    pub trait ParallelSlice<T> {
        /// Returns the elements in order.
        fn par_iter(&self) -> OneThread<Iter<'_, T>>;
        /// Returns parts of `size` elements; the last one may have fewer.
        fn par_chunks(&self, size: usize) -> OneThread<Chunks<'_, T>>;
        /// Returns mutable parts of `size` elements; the last one may have fewer.
        fn par_chunks_mut(&mut self, size: usize) -> OneThread<ChunksMut<'_, T>>;
        /// Returns mutable parts of exactly `size` elements.
        fn par_chunks_exact_mut(&mut self, size: usize) -> OneThread<ChunksExactMut<'_, T>>;
        /// Sorts by `order`; equal elements may change places.
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

    /// An iterator with rayon's methods. Those of [`Iterator`] that mean something else there are
    /// its own.
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
        /// Returns what `f` makes of each value.
        pub fn map<T, F: FnMut(I::Item) -> T>(self, f: F) -> OneThread<std::iter::Map<I, F>> {
            OneThread(self.0.map(f))
        }

        /// Returns what `f` makes of each value, with a state that `init` makes.
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

        /// Returns pairs of values; as many as the shorter of both has.
        pub fn zip<J: IntoIterator>(self, other: J) -> OneThread<std::iter::Zip<I, J::IntoIter>> {
            OneThread(self.0.zip(other))
        }

        /// Returns the same values: a hint for threads.
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

        /// Returns the first value that `f` makes something of.
        pub fn find_map_first<T>(mut self, f: impl FnMut(I::Item) -> Option<T>) -> Option<T> {
            self.0.find_map(f)
        }
    }
}
