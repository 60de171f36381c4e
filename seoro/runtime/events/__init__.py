"""Events of scenarios: channels of declared events, conditions on values and time, and subscriptions to them."""
