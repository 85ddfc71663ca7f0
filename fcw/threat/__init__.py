"""How dangerous each vehicle is: when we reach it, and whether it will be in our way then."""
