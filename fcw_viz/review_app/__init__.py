"""The review page: recorded drives in the browser, and what people say about them."""
