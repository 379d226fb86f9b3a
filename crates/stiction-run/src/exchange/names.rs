//! Unique names.

use std::collections::HashSet;

/// Names of one kind of element.
#[derive(Debug, Default)]
pub(in crate::exchange) struct Names(HashSet<String>);

impl Names {
    /// Reserves a unique name.
    pub(in crate::exchange) fn reserve(&mut self, name: &str) {
        self.0.insert(name.to_owned());
    }

    /// Returns `name`, or if that is taken the first free one of `name_2`, `name_3` and so on.
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
