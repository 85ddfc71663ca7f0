"""How dangerous each vehicle is: when we reach it, and whether it is in our way then."""
