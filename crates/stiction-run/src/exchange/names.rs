//! Unique names for the elements of an exported file.

use std::collections::HashSet;

/// Set of the names in use for one kind of element.
#[derive(Debug, Default)]
pub(in crate::exchange) struct Names(HashSet<String>);

impl Names {
    /// Marks a name as used.
    pub(in crate::exchange) fn reserve(&mut self, name: &str) {
        self.0.insert(name.to_owned());
    }

    /// Returns a unique name and marks it as used. The name is `name` itself or, if that is in use,
    /// the first unused name of `name_2`, `name_3` and so on.
    pub(in crate::exchange) fn take(&mut self, name: &str) -> String {
        let mut own = name.to_owned();
        for number in 2.. {
            if self.0.insert(own.clone()) {
                break;
            }
            own = format!("{name}_{number}");
        }
        own
    }
}

#[cfg(test)]
mod tests {
    use super::Names;

    #[test]
    fn duplicate_names_get_numbers() {
        let mut names = Names::default();
        names.reserve("world");
        let taken = ["arm", "world", "arm", "arm_2", "arm"].map(|name| names.take(name));
        assert_eq!(taken, ["arm", "world_2", "arm_2", "arm_2_2", "arm_3"]);
    }
}
