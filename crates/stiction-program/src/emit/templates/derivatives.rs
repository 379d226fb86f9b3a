
impl State {
    /// Computes the efforts as [`State::ff`] does without a direction, and their derivatives with
    /// respect to positions, rates and accelerations, in this order. The derivatives are exact and
    /// include the change of friction with the reactions. They exist only with [`Code::Done`]. If a
    /// joint slides too slowly for derivatives, the outcome is [`Code::Undetermined`].
    pub fn derivatives<M: Math>(
        &mut self,
        params: &Params,
        q: &[Real; COORDINATES],
        qd: &[Real; COORDINATES],
        qdd: &[Real; COORDINATES],
        tau: &mut [Real; ACTUATORS],
    ) -> (Code, Info, Option<[Matrix; 3]>) {
        let (code, info, found) = self.answer::<M>(params, q, (qd, qdd, None), tau);
        if code != Code::Done {
            return (code, info, None);
        }
        let all = Linear::new::<M>(params, &self.tree, (q, qd, qdd), &found)
            .and_then(|mut linear| Some([linear.by::<M>(0)?, linear.by::<M>(1)?, linear.by::<M>(2)?]));
        (if all.is_some() { code } else { Code::Undetermined }, info, all)
    }
}
